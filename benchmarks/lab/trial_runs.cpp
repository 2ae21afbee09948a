// Runs trials, measures penetration, and checks rules.
#include "lab/trial_runs.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <sstream>

#include "demos/demo.h"
#include "io/errors.h"
#include "scene/primitive_mesh.h"

namespace cloudcontact::program::lab {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kMaxLift = 0.1;  // [voxels]

using Clock = std::chrono::steady_clock;

double secondsSince(const Clock::time_point& start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Maximum penetration among many bodies with one collision shape each. Skips pairs whose bounding
// spheres are apart; World::penetration() checks all pairs, which is too slow for a pile.
class NearbyPenetration {
 public:
  explicit NearbyPenetration(const SceneDescription& scene) {
    std::map<std::string, std::shared_ptr<const Probed>> known;
    for (const SceneBody& body : scene.bodies) {
      auto& kept = known[body.collisions[0].name];
      if (!kept) kept = measured(body.collisions[0].geometry);
      double radius = kept->probes.empty() ? std::numeric_limits<double>::infinity() : 0;
      for (const Probe& probe : kept->probes)
        radius = std::max(radius, probe.position.norm() + probe.radius);
      bodies_.push_back({{{{kept, Pose()}}}, radius, body.isStatic});
    }
  }

  double deepest(const World& world) const {
    double deepest = 0;
    for (std::size_t a = 0; a < bodies_.size(); ++a)
      for (std::size_t b = a + 1; b < bodies_.size(); ++b) {
        const Body &one = bodies_[a], &other = bodies_[b];
        const Pose &at = world.pose(a), &there = world.pose(b);
        if (one.fixed && other.fixed) continue;
        if ((at.position - there.position).norm() > one.radius + other.radius) continue;
        deepest = std::max(deepest, penetration(one.solids, at, other.solids, there));
      }
    return deepest;
  }

 private:
  struct Body {
    MeasuredBody solids;
    double radius = 0;
    bool fixed = false;
  };
  static std::shared_ptr<const Probed> measured(const SceneGeometry& geometry) {
    if (const auto* box = std::get_if<SceneBox>(&geometry)) {
      const Mesh mesh = primitiveMesh(Box{box->size / 2}, box->size.norm());
      return probed(geometry, &mesh);
    }
    const auto* mesh = std::get_if<SceneMesh>(&geometry);
    return probed(geometry, mesh ? mesh->mesh.get() : nullptr);
  }

  std::vector<Body> bodies_;
};

void prepare(SceneDescription& scene, const Trial& trial, const Spring& spring) {
  scene.step = trial.step;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    SceneBody& body = scene.bodies[i];
    body.model = static_cast<int>(i);
    body.name = body.collisions[0].name + std::to_string(i);
    if (trial.mode != "stiff") continue;
    body.stiffness = 2 * spring.stiffness;
    body.damping = 2 * spring.damping;
  }
}

// simulate() for a pile, with NearbyPenetration.
SimulationReport simulateMany(World& world, const Plan& plan, double step) {
  const NearbyPenetration overlap(plan.scene);
  SimulationReport report;
  report.step = step;
  report.steps = static_cast<int>(std::llround(plan.seconds / step));
  double due = 0;
  for (int n = 1; n <= report.steps; ++n) {
    const auto start = Clock::now();
    world.step(step);
    report.wallSeconds += secondsSince(start);
    const Energy& energy = world.moment().energy;
    if (n == 1) report.energyStart = energy, report.energyMax = energy.ofBodies();
    report.energyMax = std::max(report.energyMax, energy.ofBodies());
    if (plan.observe) plan.observe(n * step, world);
    if (n * step < due && n < report.steps) continue;
    due += plan.seconds / plan.instants;
    report.maxPenetration = std::max(report.maxPenetration, overlap.deepest(world));
  }
  report.narrowPhaseSeconds = world.narrowPhaseSeconds();
  for (std::size_t i = 0; i < world.bodyCount(); ++i) report.bodies.push_back(world.state(i));
  return report;
}

void addCost(const Trial& trial, const SimulationReport& report) {
  if (!trial.cost) return;
  trial.cost->steps += report.steps;
  trial.cost->narrowPhase += report.narrowPhaseSeconds;
  trial.cost->wall += report.wallSeconds;
}

RunResult follow(const Trial& trial, Plan& plan) {
  prepare(plan.scene, trial, plan.spring);
  if (trial.watch)
    plan.observe = [own = plan.observe, watch = trial.watch](double time, const World& world) {
      if (own) own(time, world);
      watch(time, world);
    };
  World world(plan.scene, worldSettings(trial, plan.voxel));
  if (plan.many) {
    const RunResult result{plan.scene, simulateMany(world, plan, trial.step), plan.voxel};
    addCost(trial, result.report);
    return result;
  }
  SimulationSettings simulation;
  simulation.seconds = plan.seconds;
  simulation.step = trial.step;
  simulation.instants = plan.instants;
  simulation.mostProbes = std::numeric_limits<std::size_t>::max();
  simulation.observe = plan.observe;
  const RunResult result{plan.scene, simulate(world, simulation), plan.voxel};
  addCost(trial, result.report);
  return result;
}

}  // namespace

double RunResult::moved(int body, const Vec3& from) const {
  return (report.bodies[body].pose.position - from).norm() / voxel;
}

double RunResult::aside(int body) const {
  const Vec3 off = report.bodies[body].pose.position - scene.bodies[body].pose.position;
  return off.head<2>().norm() / voxel;
}

double RunResult::turned(int body) const {
  const Eigen::Quaterniond start(scene.bodies[body].pose.orientation);
  return start.angularDistance(report.bodies[body].pose.orientation) * kDegrees;
}

double RunResult::lifted() const {
  double mass = 0;
  for (const SceneBody& body : scene.bodies) mass += body.mass.value_or(0);
  return (report.energyMax - report.energyStart.ofBodies()) / (mass * kGravity * voxel);
}

Rule penetrationRule(const RunResult& result) {
  return {result.deepest(), kInPlace, "penetration [voxels]"};
}

Rule energyRule(const RunResult& result) {
  return {result.lifted(), kMaxLift, "energy gained [voxels of lift]"};
}

double turnLimit(double voxel, double lever) {
  return kInPlace * voxel / lever * kDegrees;
}

Verdict judged(const Trial& trial, Plan plan, const Rules& rules) {
  std::vector<Rule> found;
  try {
    found = rules(follow(trial, plan));
  } catch (const WorkFailed& error) {
    return {Outcome::Fails, std::numeric_limits<double>::infinity(), kInPlace, error.what()};
  }
  Verdict verdict{Outcome::Holds, found.front().figure, found.front().limit, ""};
  for (const Rule& rule : found) {
    if (rule.figure <= rule.limit) continue;  // false for NaN
    verdict.outcome = Outcome::Fails;
    verdict.why += (verdict.why.empty() ? "" : "; ") + rule.what + " " + figure(rule.figure, 3) +
                   " over " + figure(rule.limit, 3);
  }
  return verdict;
}

MovingWorld::MovingWorld(const SceneDescription& scene, const Trial& trial, double voxel)
    : world_(scene, worldSettings(trial, voxel)),
      step_(trial.step),
      watch_(trial.watch),
      cost_(trial.cost) {}

void MovingWorld::step() {
  const auto start = Clock::now();
  const double narrow = world_.narrowPhaseSeconds();
  world_.step(step_);
  if (cost_) {
    ++cost_->steps;
    cost_->narrowPhase += world_.narrowPhaseSeconds() - narrow;
    cost_->wall += secondsSince(start);
  }
  const Energy& energy = world_.moment().energy;
  if (steps_++ == 0) start_ = most_ = energy.ofBodies() + energy.spring;
  most_ = std::max(most_, energy.ofBodies());
  if (watch_) watch_(time(), world_);
}

void MovingWorld::run(double seconds, const std::function<bool()>& enough) {
  while (time() < seconds - 0.5 * step_ && !(enough && enough())) step();
}

Verdict failIfGains(const Verdict& verdict, double gained, double scale) {
  if (verdict.outcome != Outcome::Holds || gained <= 0.01 * scale) return verdict;
  std::ostringstream why;
  why.precision(2);
  why << "gained " << 100 * gained / scale << " % energy";
  return {Outcome::Fails, verdict.figure, verdict.limit, why.str()};
}

Verdict atLeast(double figure, double limit, const std::string& otherwise) {
  const bool holds = figure >= limit;  // false for NaN
  return {holds ? Outcome::Holds : Outcome::Fails, figure, limit, holds ? "" : otherwise};
}

double turningPoint(double low, double high, int halvings,
                    const std::function<bool(double)>& holds) {
  if (!holds(low)) return low;
  if (holds(high)) return high;
  for (int i = 0; i < halvings; ++i) {
    const double middle = (low + high) / 2;
    (holds(middle) ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace cloudcontact::program::lab
