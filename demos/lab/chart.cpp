// Measures: errors over several grids and depths, time on the first.
#include "lab/chart.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

namespace cloudcontact::program::lab {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kGrids = 6, kQuickGrids = 1;
constexpr double kFinest = 1.0 / 64, kQuickFinest = 1.0 / 32;
constexpr double kTimed = 0.15, kQuickTimed = 0.03;  // [s] that a time is taken over

double meanOf(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return values.empty() ? kUnknown : sum / double(values.size());
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return kUnknown;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::ceil(share * double(values.size() - 1)))];
}

struct Errors {
  std::vector<double> normal, depth, centre, force, torque;

  void add(const AnswerError& e) {
    normal.push_back(e.normalDeg);
    const auto known = [](std::vector<double>& to, double v) {
      if (!std::isnan(v)) to.push_back(v);
    };
    known(depth, e.depth), known(centre, e.centre);
    known(force, e.force), known(torque, e.torque);
  }
};

double timeOf(const LabPair& pair, const Pose& pose, double jitter, double seconds) {
  const double first = quantile(pair.microseconds(pose, 3, jitter), 0.5);
  const int repeat = std::clamp(static_cast<int>(1e6 * seconds / std::max(first, 0.1)), 3, 2000);
  return quantile(pair.microseconds(pose, repeat, jitter), 0.5);
}

ChartRow rowOf(const LabCase& one, const LabMethod& method) {
  ChartRow row;
  row.family = one.family, row.name = one.name, row.convex = one.convex, row.smooth = one.smooth;
  row.method = method.method, row.setting = method.setting, row.detail = method.detail;
  return row;
}

// Grids matter to clouds alone; the finest and slowest is asked on few.
int gridsOf(const LabMethod& method, bool quick) {
  if (method.method != "cloud") return 1;
  const int grids = quick ? kQuickGrids : kGrids;
  return method.detail < 1.0 / 40 ? std::min(grids, 2) : grids;
}

// A case's instances, made once for all methods: some truths are minutes of quadrature in all.
class Instances {
 public:
  explicit Instances(const LabCase& one) : case_(one) {}
  const Instance& with(std::uint64_t seed) {
    const auto [known, isNew] = made_.try_emplace(seed);
    if (isNew) known->second = case_.make(seed);
    return known->second;
  }

 private:
  const LabCase& case_;
  std::map<std::uint64_t, Instance> made_;
};

ChartRow measured(const LabCase& one, Instances& instances, const LabMethod& method,
                  const ChartSettings& settings) {
  ChartRow row = rowOf(one, method);
  Errors errors;
  const double detail = method.detail * one.size;
  for (int g = 0; g < gridsOf(method, settings.quick); ++g) {
    const Instance& instance = instances.with(static_cast<std::uint64_t>(g) + 1);
    const LabPair pair = method.prepare(instance.a, instance.b, detail);
    for (const Placement& p : instance.placements) {
      const auto points = pair.find(p.b);
      ++row.runs;
      if (points.empty())
        ++row.missed;
      else
        errors.add(errorOf(points, p.truth, one.size));
    }
    if (g > 0) continue;
    const Placement& middle = instance.placements[instance.placements.size() / 2];
    row.microseconds =
        timeOf(pair, middle.b, 1e-3 * one.size / 32, settings.quick ? kQuickTimed : kTimed);
  }
  row.normalDeg = {meanOf(errors.normal), quantile(errors.normal, 0.95),
                   quantile(errors.normal, 1)};
  row.depth = meanOf(errors.depth), row.centre = meanOf(errors.centre);
  row.force = meanOf(errors.force), row.torque = meanOf(errors.torque);
  if (row.missed == row.runs) row.why = "finds nothing though the bodies touch";
  return row;
}

std::vector<LabMethod> methodsOf(const ChartSettings& settings) {
  std::vector<LabMethod> methods = cloudMethods();
  for (LabMethod& m : bulletMethods()) methods.push_back(std::move(m));
  for (LabMethod& m : otherMethods()) methods.push_back(std::move(m));
  const double finest = settings.quick ? kQuickFinest : kFinest;
  std::erase_if(methods, [&](const LabMethod& m) {
    const bool slow = m.method == "hacd";  // cuts each body for seconds to a minute
    return (m.method == "cloud" && m.detail < 0.99 * finest) || (settings.quick && slow);
  });
  return methods;
}

}  // namespace

AnswerError errorOf(const std::vector<LabPoint>& points, const Truth& truth, double size) {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();  // torque about the true centre, or the origin
  const Vec3 centre = truth.centre.value_or(Vec3::Zero());
  double deepest = 0;
  for (const LabPoint& p : points) {
    const Vec3 f = p.share * p.depth * p.normal;
    force += f;
    torque += (p.position - centre).cross(f);
    deepest = std::max(deepest, p.depth);
  }
  AnswerError error;
  const double size2 = force.norm();
  if (!(size2 > 0)) return error;
  const Vec3 along = truth.direction.normalized();
  error.normalDeg = std::atan2(force.cross(along).norm(), force.dot(along)) / kDegree;
  if (truth.depth) {
    error.depth = std::abs(deepest - *truth.depth);
    error.force = std::abs(size2 / *truth.depth - 1);
  }
  if (truth.centre) {
    const Vec3 across = torque - torque.dot(force) / size2 * force / size2;
    error.centre = across.norm() / size2;
    error.torque = torque.norm() / (size2 * size);
  }
  if (truth.torquePerForce) {
    const double found = torque.z() / force.z();
    error.torque = std::abs(found / *truth.torquePerForce - 1);
  }
  return error;
}

std::vector<FamilyMark> familyMarks(const std::vector<ChartRow>& rows) {
  std::map<std::tuple<std::string, std::string, std::string>, std::vector<const ChartRow*>> groups;
  std::vector<std::tuple<std::string, std::string, std::string>> order;
  for (const ChartRow& row : rows) {
    auto& group = groups[{row.family, row.method, row.setting}];
    if (group.empty()) order.emplace_back(row.family, row.method, row.setting);
    group.push_back(&row);
  }
  std::vector<FamilyMark> marks;
  for (const auto& key : order) {
    FamilyMark mark{std::get<0>(key), std::get<1>(key), std::get<2>(key), 0, 0, 0, 0, 0, false};
    double logTime = 0;
    for (const ChartRow* row : groups[key]) {
      if (!row->why.empty()) {
        ++mark.cannot;
        continue;
      }
      ++mark.cases;
      logTime += std::log(row->microseconds);
      mark.normalDeg += row->normalDeg.mean;
      const double force = std::isnan(row->force) ? 0 : row->force;
      mark.wrench += std::max(force, std::isnan(row->torque) ? 0 : row->torque);
    }
    if (mark.cases > 0) {
      mark.microseconds = std::exp(logTime / mark.cases);
      mark.normalDeg /= mark.cases, mark.wrench /= mark.cases;
    }
    marks.push_back(mark);
  }
  for (FamilyMark& one : marks) {
    one.frontier = one.cases > 0 && one.cannot == 0;
    for (const FamilyMark& other : marks)
      if (other.family == one.family && other.cases > 0 && other.cannot == 0 &&
          other.microseconds < one.microseconds && other.normalDeg < one.normalDeg)
        one.frontier = false;
  }
  return marks;
}

void markFrontier(std::vector<ChartRow>& rows) {
  for (const FamilyMark& mark : familyMarks(rows))
    for (ChartRow& row : rows)
      if (row.family == mark.family && row.method == mark.method && row.setting == mark.setting)
        row.frontier = mark.frontier;
}

std::vector<ChartRow> runChart(const std::vector<LabCase>& cases,
                               const std::vector<LabMethod>& methods,
                               const ChartSettings& settings) {
  std::vector<ChartRow> rows;
  for (const LabCase& one : cases) {
    Instances instances(one);
    for (const LabMethod& method : methods) {
      try {
        rows.push_back(measured(one, instances, method, settings));
      } catch (const std::exception& error) {  // CannotDo, or a body that it cannot take
        rows.push_back(rowOf(one, method));
        rows.back().why = error.what();
      }
      if (settings.progress)
        settings.progress(double(rows.size()) / double(cases.size() * methods.size()));
    }
  }
  markFrontier(rows);
  return rows;
}

namespace {

// What a method finds, as the truth for the others.
Truth asTruth(const std::vector<LabPoint>& points) {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double deepest = 0;
  for (const LabPoint& p : points) {
    const Vec3 f = p.share * p.depth * p.normal;
    force += f, torque += p.position.cross(f);
    deepest = std::max(deepest, p.depth);
  }
  if (!(force.norm() > 0))
    throw std::runtime_error("chart: the bodies do not touch at this --pose; press them together");
  Truth truth;
  truth.direction = force.normalized();
  truth.depth = force.norm();
  truth.centre = force.cross(torque) / force.squaredNorm();
  return truth;
}

}  // namespace

std::vector<ChartRow> runChart(const ChartSettings& settings) {
  std::vector<LabCase> cases = allCases();
  std::erase_if(cases, [&](const LabCase& one) {
    const bool wanted = one.name.find(settings.only) != std::string::npos ||
                        one.family.find(settings.only) != std::string::npos;
    return !wanted || (settings.quick && !one.quick);
  });
  return runChart(cases, methodsOf(settings), settings);
}

std::vector<ChartRow> runChart(const LabCase& pair, const ChartSettings& settings) {
  std::vector<LabMethod> methods = methodsOf({});
  const auto finest =
      std::min_element(methods.begin(), methods.end(), [](const LabMethod& a, const LabMethod& b) {
        return std::pair(a.method != "cloud", a.detail) < std::pair(b.method != "cloud", b.detail);
      });
  const Instance instance = pair.make(1000);
  const LabPair reference = finest->prepare(instance.a, instance.b, finest->detail * pair.size);
  const Truth truth = asTruth(reference.find(instance.placements.front().b));
  methods.erase(finest);
  LabCase known = pair;
  known.make = [=](std::uint64_t seed) {
    Instance one = pair.make(seed);
    for (Placement& p : one.placements) p.truth = truth;
    return one;
  };
  return runChart({known}, methods, settings);
}

}  // namespace cloudcontact::program::lab
