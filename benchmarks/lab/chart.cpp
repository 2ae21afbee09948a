// Measures: errors over several grids and depths, methods side by side; times on the first grid,
// each method alone.
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
constexpr double kTimed = 0.15, kQuickTimed = 0.03;  // [s] that a time is taken over
constexpr int kLoopSteps = 24;
constexpr double kLoopSeconds = 1;  // loops that would take longer are left out

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

// The sum over tetrahedra.
double volumeOf(const Mesh& mesh) {
  double six = 0;
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](int k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    six += corner(0).dot(corner(1).cross(corner(2)));
  }
  return six / 6;
}

struct Errors {
  std::vector<double> normal, depth, depthTimes, centre, force, torque;

  void add(const AnswerError& e) {
    normal.push_back(e.normalDeg);
    const auto known = [](std::vector<double>& to, double v) {
      if (!std::isnan(v)) to.push_back(v);
    };
    known(depth, e.depth), known(depthTimes, e.depthTimes), known(centre, e.centre);
    known(force, e.force), known(torque, e.torque);
  }
  void summarise(ChartRow& row) const {
    row.normalDeg = {meanOf(normal), quantile(normal, 0.95), quantile(normal, 1)};
    row.depth = meanOf(depth), row.depthTimes = meanOf(depthTimes), row.centre = meanOf(centre);
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

// Grids matter to clouds alone; the finest and slowest is asked on few.
int gridsOf(const LabMethod& method, bool quick) {
  if (method.method != "cloud") return 1;
  const int grids = quick ? kQuickGrids : kGrids;
  return method.detail < 1.0 / 40 ? std::min(grids, 2) : grids;
}

// A case's instances, made once for all methods.
class Instances {
 public:
  explicit Instances(const LabCase& one) : case_(one) {}
  const Instance& with(std::uint64_t seed) {
    const std::lock_guard lock(mutex_);
    const auto [known, isNew] = made_.try_emplace(seed);
    if (isNew) known->second = case_.make(seed);
    return known->second;
  }

  // Of both bodies, by their facets [m^3].
  double volume() {
    const Instance& instance = with(1);
    const std::lock_guard lock(mutex_);
    for (const LabBody* body : {&instance.a, &instance.b})
      if (!volumeKnown_) volume_ += volumeOf(body->mesh(kFineVolume * case_.size));
    volumeKnown_ = true;
    return volume_;
  }

 private:
  static constexpr double kFineVolume = 5e-4;  // that facets may lie off the solid, by its size

  const LabCase& case_;
  std::map<std::uint64_t, Instance> made_;
  double volume_ = 0;
  bool volumeKnown_ = false;
  std::mutex mutex_;
};

const Placement& middleOf(const Instance& instance) {
  return instance.placements[instance.placements.size() / 2];
}

// A method on a case: what it says, and then how long it takes to say it.
class Measurement {
 public:
  Measurement(const LabCase& one, Instances& instances, const LabMethod& method,
              const ChartSettings& settings)
      : case_(one),
        instances_(instances),
        method_(method),
        settings_(settings),
        row_(rowOf(one, method)) {}

  const std::string& method() const { return method_.method; }

  // May run beside other methods'.
  void ask() {
    attempt([this] {
      for (int g = 0; g < gridsOf(method_, settings_.quick); ++g) askOn(g);
      errors_.summarise(row_);
      if (row_.missed == row_.runs) row_.why = "finds nothing though the bodies touch";
    });
  }
  // Alone on the machine.
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
  // What throws has no answer: CannotDo, or a body that it cannot take.
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

  void askOn(int grid) {
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
    lookAround(instance);
    count(instance);
  }

  // Swapped, and around a loop.
  void lookAround(const Instance& instance) {
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
  Instances& instances_;
  const LabMethod& method_;
  const ChartSettings& settings_;
  ChartRow row_;
  Errors errors_;
  std::optional<LabPair> first_;  // on the first grid
};

// Two threads ask different libraries at once, never the same one: ODE and MuJoCo allow no more.
void askAll(std::vector<Measurement>& all, int threads) {
  std::vector<std::vector<Measurement*>> lanes;
  for (Measurement& one : all) {
    const bool own =
        one.method() == "cloud" || lanes.empty() || lanes.back().front()->method() != one.method();
    if (own) lanes.emplace_back();
    lanes.back().push_back(&one);
  }
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < lanes.size(); i = next++)
      for (Measurement* one : lanes[i]) one->ask();
  };
  std::vector<std::thread> others;
  for (int t = 1; t < threads; ++t) others.emplace_back(work);
  work();
  for (std::thread& other : others) other.join();
}

}  // namespace

std::vector<LabMethod> chartMethods(const ChartSettings& settings) {
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

std::vector<ChartRow> runChart(const std::vector<LabCase>& cases,
                               const std::vector<LabMethod>& methods,
                               const ChartSettings& settings) {
  std::vector<ChartRow> rows;
  for (const LabCase& one : cases) {
    Instances instances(one);
    std::vector<Measurement> measurements;
    for (const LabMethod& method : methods)
      measurements.emplace_back(one, instances, method, settings);
    askAll(measurements, settings.threads);
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

}  // namespace cloudcontact::program::lab
