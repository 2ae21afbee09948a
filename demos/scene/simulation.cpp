// The loop of steps and its measurements.
#include "scene/simulation.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "io/text.h"

namespace cloudcontact::program {
namespace {

constexpr int kLeastInstants = 10;

// Unwrapped rotations: sums the small rotations between states as vectors in the world. A driven
// body may turn by more than half a turn a step, and does so at its velocity.
class TurnCounter {
 public:
  explicit TurnCounter(const World& world) { take(world); }
  void count(const World& world, double seconds) {
    take(world);
    for (std::size_t i = 0; i < last_.size(); ++i) {
      if (world.isStatic(i)) continue;
      if (world.mass(i) == 0) {
        turns_[i] += seconds * world.state(i).angularVelocity;
        continue;
      }
      const Eigen::Quaterniond now = world.pose(i).orientation;
      const Eigen::AngleAxisd turned(now * last_[i].conjugate());
      turns_[i] += turned.angle() * turned.axis();
      last_[i] = now;
    }
  }
  const std::vector<Vec3>& turns() const { return turns_; }

 private:
  // Bodies that are new.
  void take(const World& world) {
    for (std::size_t i = last_.size(); i < world.bodyCount(); ++i) {
      last_.push_back(world.pose(i).orientation);
      turns_.push_back(Vec3::Zero());
    }
  }

  std::vector<Eigen::Quaterniond> last_;
  std::vector<Vec3> turns_;
};

// The steps after which penetration is measured.
class Instants {
 public:
  Instants(int steps, const SimulationSettings& settings, std::size_t probes) : steps_(steps) {
    const auto affordable = static_cast<int>(
        std::min<std::size_t>(1'000'000, settings.mostProbes / std::max<std::size_t>(1, probes)));
    wanted_ = std::clamp(std::min(settings.instants, std::max(affordable, kLeastInstants)), 1,
                         std::max(1, steps));
  }
  // The n-th of N instants comes after step round(n steps / N).
  bool after(int step) {
    const auto due = static_cast<int>(std::llround(double(next_) * steps_ / wanted_));
    if (step < due) return false;
    ++next_;
    return true;
  }

 private:
  int steps_, wanted_ = 1, next_ = 1;
};

// Tells what World::penetration() leaves out, whose overlap is not 0 but unknown.
std::string overlapText(const World& world, double deepest) {
  if (!world.measuresPenetration()) return "not measured";
  std::vector<std::string> without;
  for (std::size_t i = 0; i < world.bodyCount(); ++i)
    if (!world.isMeasured(i)) without.push_back(world.name(i));
  if (without.empty()) return lengthText(deepest);
  const std::string one = "'" + without.front() + "'";
  return lengthText(deepest) + ", without " +
         (without.size() == 1 ? one : std::to_string(without.size()) + " bodies");
}

}  // namespace

SimulationReport simulate(World& world, const SimulationSettings& settings) {
  using Clock = std::chrono::steady_clock;
  SimulationReport report;
  report.step = settings.step;
  const int planned = std::max(1, static_cast<int>(std::llround(settings.seconds / settings.step)));
  const double substep = settings.step / settings.substeps;
  TurnCounter turns(world);
  Instants instants(planned, settings, world.probes());
  if (settings.observe) settings.observe(0, world);
  long substeps = 0;
  bool goesOn = !settings.goesOn || settings.goesOn(0);
  int& n = report.steps;
  while (n < planned && (goesOn || n == 0)) {  // at least one step, for the figures
    if (settings.control) settings.control(n * settings.step, world);
    ++n;
    for (int s = 0; s < settings.substeps; ++s) {
      const auto start = Clock::now();
      world.step(substep);
      report.wallSeconds += std::chrono::duration<double>(Clock::now() - start).count();
      turns.count(world, substep);
      const ContactMoment& moment = world.moment();
      if (substeps++ == 0) {
        report.energyStart = moment.energy;
        report.energyMax = moment.energy.ofBodies();
      }
      report.energyMax = std::max(report.energyMax, moment.energy.ofBodies());
      report.springEnergyMax = std::max(report.springEnergyMax, moment.energy.spring);
      report.pairs += moment.pairs;
      report.contactsPerStep += moment.contacts;
    }
    if (settings.instants > 0 && instants.after(n))
      report.maxPenetration = std::max(report.maxPenetration, world.penetration());
    if (settings.observe) settings.observe(n * settings.step, world);
    if (settings.goesOn) goesOn = settings.goesOn(n * settings.step);
  }
  if (n < planned && settings.instants > 0)
    report.maxPenetration = std::max(report.maxPenetration, world.penetration());
  report.pairs /= double(substeps);
  report.contactsPerStep /= double(substeps);
  report.narrowPhaseSeconds = world.narrowPhaseSeconds();
  report.narrowPhaseThreadSeconds = world.narrowPhaseThreadSeconds();
  report.solverSeconds = world.solverSeconds();
  report.work = world.work();
  report.realTimeFactor = report.steps * settings.step / report.wallSeconds;
  report.hash = world.hash();
  for (std::size_t i = 0; i < world.bodyCount(); ++i) report.bodies.push_back(world.state(i));
  report.turns = turns.turns();
  // The energy of the last state needs the depths of its contacts, which no step has found yet.
  world.findContacts();
  report.energyEnd = world.moment().energy;
  report.energyMax = std::max(report.energyMax, report.energyEnd.ofBodies());
  return report;
}

SimulationReport simulateShort(World& world, const SimulationSettings& of, int steps, double most) {
  const auto start = std::chrono::steady_clock::now();
  SimulationSettings settings;
  settings.step = of.step;
  settings.control = of.control;
  settings.seconds = steps * of.step;
  settings.instants = 0;
  settings.goesOn = [&](double) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() < most;
  };
  return simulate(world, settings);
}

std::string setupText(const WorldSettings& settings, double step, int substeps) {
  const std::string steps = ", steps of " + timeText(step) +
                            (substeps > 1 ? " in " + std::to_string(substeps) + " parts" : "");
  switch (settings.common.method) {
    case Method::Cloud:
      return "clouds of " + lengthText(settings.voxel) + " voxels" + steps;
    case Method::Paper:
      return "base vectors in clouds of " + lengthText(settings.voxel) + " voxels" + steps;
    case Method::Gjk:
      return "Bullet's GJK on convex hulls" + steps;
    case Method::Gimpact:
      return "Bullet's GImpact" + steps;
    case Method::Hacd:
      return "convex parts by HACD" + steps;
    case Method::Primitive:
      return "Bullet's own primitives" + steps;
    case Method::Sdf:
      return "Bullet's signed distance fields" + steps;
  }
  return "";
}

std::vector<std::pair<std::string, std::string>> factsOf(const World& world,
                                                         const SimulationReport& r) {
  return {{"Deepest overlap, by the meshes", overlapText(world, r.maxPenetration)},
          {"Contacts a step", numberText(r.contactsPerStep)},
          {"Narrow phase a step", timeText(r.narrowPhaseSeconds / r.steps)},
          {"Energy at the start", energyText(r.energyStart.ofBodies())},
          {"Energy at the end", energyText(r.energyEnd.ofBodies())},
          {"Speed", numberText(r.realTimeFactor) + " \u00d7 real time"}};
}

}  // namespace cloudcontact::program
