// Errors are measured over several grids and depths, methods in parallel. Times are measured on the
// first grid, one method at a time.
#include "lab/chart.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <map>
#include <mutex>
#include <thread>

#include "lab/families.h"

namespace cloudcontact::program::lab {
namespace {

constexpr int kGrids = 6, kQuickGrids = 1;
constexpr double kFinest = 1.0 / 64, kQuickFinest = 1.0 / 32;
constexpr double kTimed = 0.15, kQuickTimed = 0.03;  // [s] duration of a time measurement
constexpr int kLoopSteps = 24;
constexpr double kLoopSeconds = 1;  // slower loops are skipped

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

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

// Sum over signed tetrahedra.
double volumeOf(const Mesh& mesh) {
  double six = 0;
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](int k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    six += corner(0).dot(corner(1).cross(corner(2)));
  }
  return six / 6;
}

struct Errors {
  std::vector<double> normal, depth, depthTimes, center, force, torque;

  void add(const AnswerError& e) {
    normal.push_back(e.normalDeg);
    const auto known = [](std::vector<double>& to, double v) {
      if (!std::isnan(v)) to.push_back(v);
    };
    known(depth, e.depth), known(depthTimes, e.depthTimes), known(center, e.center);
    known(force, e.force), known(torque, e.torque);
  }
  void summarize(ChartRow& row) const {
    row.normalDeg = {meanOf(normal), quantile(normal, 0.95), quantile(normal, 1)};
    row.depth = meanOf(depth), row.depthTimes = meanOf(depthTimes), row.center = meanOf(center);
    row.force = meanOf(force), row.torque = meanOf(torque);
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

// Only our own methods depend on the grid. The finest, which are slow, use at most two.
int gridsOf(const LabMethod& method, bool quick) {
  if (!isOwn(method.method)) return 1;
  const int grids = quick ? kQuickGrids : kGrids;
  return method.detail < 1.0 / 40 ? std::min(grids, 2) : grids;
}

// A case's instances, shared by all methods.
class InstanceCache {
 public:
  explicit InstanceCache(const LabCase& one) : case_(one) {}
  const Instance& with(std::uint64_t seed) {
    const std::lock_guard lock(mutex_);
    const auto [known, isNew] = made_.try_emplace(seed);
    if (isNew) known->second = case_.make(seed);
    return known->second;
  }

  // Volume of both bodies, from fine facets [m^3].
  double volume() {
    const Instance& instance = with(1);
    const std::lock_guard lock(mutex_);
    for (const LabBody* body : {&instance.a, &instance.b})
      if (!volumeKnown_) volume_ += volumeOf(body->mesh(kFineVolume * case_.size));
    volumeKnown_ = true;
    return volume_;
  }

 private:
  static constexpr double kFineVolume = 5e-4;  // facet tolerance / size

  const LabCase& case_;
  std::map<std::uint64_t, Instance> made_;
  double volume_ = 0;
  bool volumeKnown_ = false;
  std::mutex mutex_;
};

const Placement& middleOf(const Instance& instance) {
  return instance.placements[instance.placements.size() / 2];
}

// One method on one case: first its errors, then its time.
class Measurement {
 public:
  Measurement(const LabCase& one, InstanceCache& instances, const LabMethod& method,
              const ChartSettings& settings)
      : case_(one),
        instances_(instances),
        method_(method),
        settings_(settings),
        row_(rowOf(one, method)) {}

  const std::string& method() const { return method_.method; }

  // May run in parallel with other methods.
  void measure() {
    attempt([this] {
      for (int g = 0; g < gridsOf(method_, settings_.quick); ++g) measureOn(g);
      errors_.summarize(row_);
      if (row_.missed == row_.runs) row_.why = "finds nothing though the bodies touch";
    });
  }
  // Must run alone.
  ChartRow timed() {
    if (first_ && row_.why.empty())
      attempt([this] {
        row_.microseconds = timeOf(*first_, middleOf(instances_.with(1)).b, 1e-3 * case_.size / 32,
                                   settings_.quick ? kQuickTimed : kTimed);
      });
    first_.reset();
    return row_;
  }

 private:
  // Any exception means that the method has no answer: CannotDo, or an error of its own.
  template <class Work>
  void attempt(const Work& work) {
    const auto start = Clock::now();
    try {
      work();
    } catch (const std::exception& error) {
      row_.why = error.what();
    }
    row_.seconds += secondsSince(start);
  }

  void measureOn(int grid) {
    const Instance& instance = instances_.with(static_cast<std::uint64_t>(grid) + 1);
    LabPair pair = method_.prepare(instance.a, instance.b, detail());
    for (const Placement& p : instance.placements) {
      const auto points = pair.find(p.b);
      ++row_.runs;
      if (points.empty()) {
        ++row_.missed;
        continue;
      }
      const AnswerError error = errorOf(points, p.truth, case_.size);
      row_.wrongDepth += error.wrongDepth;
      errors_.add(error);
    }
    if (grid > 0) return;
    first_ = std::move(pair);
    measureSymmetry(instance);
    count(instance);
  }

  // The swapped pair and the closed loop.
  void measureSymmetry(const Instance& instance) {
    const Placement& middle = middleOf(instance);
    const auto start = Clock::now();
    const auto points = first_->find(middle.b);
    if (points.empty()) return;
    if (secondsSince(start) * kLoopSteps < kLoopSeconds)
      row_.loopWork = loopWork(*first_, middle.b, middle.truth.direction,
                               0.5 * kDepths[0] * case_.size, kLoopSteps);
    const LabPair swapped =
        first_->swapped ? first_->swapped() : method_.prepare(instance.b, instance.a, detail());
    row_.swapped = swapError(points, swapped, middle.b);
  }

  void count(const Instance& instance) {
    const LabBody* bodies[] = {&instance.a, &instance.b};
    for (int k = 0; k < 2 && method_.facets; ++k) {
      if (!bodies[k]->mesh) continue;
      const Mesh mesh = bodies[k]->mesh(detail());
      row_.triangles[k] = mesh.triangles.size(), row_.vertices[k] = mesh.vertices.size();
    }
    if (first_->volume) row_.volume = std::abs(*first_->volume / instances_.volume() - 1);
  }

  double detail() const { return method_.detail * case_.size; }

  const LabCase& case_;
  InstanceCache& instances_;
  const LabMethod& method_;
  const ChartSettings& settings_;
  ChartRow row_;
  Errors errors_;
  std::optional<LabPair> first_;  // prepared on the first grid
};

// Each peer library runs on one thread at a time: ODE and MuJoCo are not thread-safe.
void measureAll(std::vector<Measurement>& all, int threads) {
  std::vector<std::vector<Measurement*>> lanes;
  for (Measurement& one : all) {
    const bool own =
        isOwn(one.method()) || lanes.empty() || lanes.back().front()->method() != one.method();
    if (own) lanes.emplace_back();
    lanes.back().push_back(&one);
  }
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < lanes.size(); i = next++)
      for (Measurement* one : lanes[i]) one->measure();
  };
  std::vector<std::thread> others;
  for (int t = 1; t < threads; ++t) others.emplace_back(work);
  work();
  for (std::thread& other : others) other.join();
}

// The reference method's answer as the truth for the others.
Truth asTruth(const std::vector<LabPoint>& points) {
  Vec3 torque = Vec3::Zero();
  double deepest = 0;
  for (const LabPoint& p : points) {
    torque += p.position.cross(p.share * p.depth * p.normal);
    deepest = std::max(deepest, p.depth);
  }
  const Vec3 force = forceOf(points);
  if (!(force.norm() > 0))
    throw std::runtime_error("chart: the bodies do not touch at this --pose; press them together");
  Truth truth;
  truth.direction = force.normalized();
  truth.depth = force.norm();
  truth.deepest = deepest;
  truth.center = force.cross(torque) / force.squaredNorm();
  return truth;
}

}  // namespace

std::vector<LabMethod> chartMethods(const ChartSettings& settings) {
  std::vector<LabMethod> methods = cloudMethods();
  for (LabMethod& m : paperMethods()) methods.push_back(std::move(m));
  for (LabMethod& m : bulletMethods()) methods.push_back(std::move(m));
  for (LabMethod& m : otherMethods()) methods.push_back(std::move(m));
  const double finest = settings.quick ? kQuickFinest : kFinest;
  std::erase_if(methods, [&](const LabMethod& m) {
    const bool slow = m.method == "hacd";  // decomposes a body in seconds to a minute
    const bool wanted = settings.method.empty() || m.method == settings.method;
    return !wanted || (m.method == "cloud" && m.detail < 0.99 * finest) || (settings.quick && slow);
  });
  return methods;
}

std::vector<ChartRow> runChart(const std::vector<LabCase>& cases,
                               const std::vector<LabMethod>& methods,
                               const ChartSettings& settings) {
  std::vector<ChartRow> rows;
  for (const LabCase& one : cases) {
    InstanceCache instances(one);
    std::vector<Measurement> measurements;
    for (const LabMethod& method : methods)
      measurements.emplace_back(one, instances, method, settings);
    measureAll(measurements, settings.threads);
    for (Measurement& measurement : measurements) {
      rows.push_back(measurement.timed());
      if (settings.progress)
        settings.progress(double(rows.size()) / double(cases.size() * methods.size()));
    }
  }
  markFrontier(rows);
  return rows;
}

std::vector<ChartRow> runChart(const ChartSettings& settings) {
  std::vector<LabCase> cases = allCases();
  std::erase_if(cases, [&](const LabCase& one) {
    const bool wanted = one.name.find(settings.only) != std::string::npos ||
                        one.family.find(settings.only) != std::string::npos;
    return !wanted || (settings.quick && !one.quick);
  });
  return runChart(cases, chartMethods(settings), settings);
}

std::vector<ChartRow> runChart(const LabCase& pair, const ChartSettings& settings) {
  std::vector<LabMethod> methods = chartMethods({});
  const auto finest =
      std::min_element(methods.begin(), methods.end(), [](const LabMethod& a, const LabMethod& b) {
        return std::pair(a.method != "cloud", a.detail) < std::pair(b.method != "cloud", b.detail);
      });
  const Instance instance = pair.make(1000);
  const LabPair reference = finest->prepare(instance.a, instance.b, finest->detail * pair.size);
  const Truth truth = asTruth(reference.find(instance.placements.front().b));
  methods.erase(finest);
  std::erase_if(methods, [&](const LabMethod& m) {
    return !settings.method.empty() && m.method != settings.method;
  });
  LabCase known = pair;
  known.make = [=](std::uint64_t seed) {
    Instance one = pair.make(seed);
    for (Placement& p : one.placements) p.truth = truth;
    return one;
  };
  return runChart({known}, methods, settings);
}

}  // namespace cloudcontact::program::lab
