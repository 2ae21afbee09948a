// Mechanisms whose motion a formula gives: incline, screw, peg, gears, bowl, Newton's cradle.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "lab/lab_meshes.h"
#include "lab/trial_runs.h"
#include "scene/generated_mesh.h"

namespace cloudcontact::program::lab {
namespace {

constexpr double kPi = std::numbers::pi;

// --- A brick on an incline of slope 0.5: slides at friction 0.49, stands at 0.50.

namespace incline {

constexpr double kSlope = 0.5, kVoxel = 0.02, kSeconds = 2;

// Distance that the brick slides [m]. Gravity is tilted, not the incline, which is equivalent.
double slid(const Trial& trial, double friction) {
  const double angle = std::atan(kSlope);
  SceneDescription scene;
  scene.gravity = kGravity * Vec3(std::sin(angle), 0, -std::cos(angle));
  const Matter brick = springMatter(1, friction, 4400, 1);  // sag 0.1 voxel
  addBody(scene, "incline", boxFor(trial, Vec3(2, 1, 0.2)), Vec3(0, 0, -0.1), {0, 1}, trial);
  const double sag = sagOf(trial, brick, brick.mass * kGravity * std::cos(angle), kVoxel);
  SceneBody& body = addBody(scene, "brick", boxFor(trial, Vec3(0.4, 0.4, 0.1)),
                            Vec3(-0.4, 0, 0.05 - sag), brick, trial);
  body.pose.orientation = Eigen::AngleAxisd(0.3, Vec3::UnitZ());  // not along a grid axis
  MovingWorld motion(scene, trial, kVoxel);
  motion.run(kSeconds);
  return motion.body(1).pose.position.x() + 0.4;
}

// Distance in theory: g (sin - mu cos) t^2 / 2 [m].
double freeWay(double friction) {
  const double angle = std::atan(kSlope);
  return kGravity * (std::sin(angle) - friction * std::cos(angle)) / 2 * kSeconds * kSeconds;
}

Verdict slides(const Trial& trial) {
  const double free = freeWay(0.49), way = slid(trial, 0.49);
  return within(way, free, 0.2, way < free ? "is held back" : "runs ahead");
}

// At friction 0.50 the forces just balance: nothing removes speed left over from the first steps.
Verdict stands(const Trial& trial) {
  return atMost(100 * std::abs(slid(trial, 0.5)) / freeWay(0.49), 10, "slides");
}

}  // namespace incline

// --- A nut turns down its bolt. Above which friction does it stop?

namespace screw {

constexpr double kVoxel = 0.25e-3, kSeconds = 0.4;
constexpr double kPlay = 0.1e-3;  // radial clearance of the threads
constexpr double kApart = 40e-3;  // distance of neighboring bolts
constexpr double kMass = 0.02;
constexpr double kSpin = 0.5;  // initial [rad/s]

Thread threadFor(const Trial& trial) {
  Thread thread;
  // Fewer triangles for peers, whose time depends on them.
  thread.segments = usesClouds(trial.method) ? 96 : 48;
  return thread;
}

// The flanks touch from the nut's minor to the bolt's major radius; friction acts half way.
double contactRadius(const Thread& t) {
  const double minor = t.majorDiameter / 2 - 5.0 / 16 * t.pitch / std::tan(t.flankAngle / 2);
  return (minor + kPlay + t.majorDiameter / 2) / 2;
}

double theory(const Thread& t) {
  return t.lead() / (2 * kPi * contactRadius(t)) * std::cos(t.flankAngle / 2);
}

struct Nuts {
  std::vector<bool> stayed;
  bool threaded = true;  // all are still on their threads
};

// One nut per friction, each on its own bolt, in one world that shares one pair of fields.
SceneDescription sceneOf(const Trial& trial, const std::vector<double>& frictions) {
  const Thread thread = threadFor(trial);
  Thread nutThread = thread;
  nutThread.clearance = kPlay;
  const auto bolt = std::make_shared<const Mesh>(boltMesh(thread, 10e-3));
  const auto nut = std::make_shared<const Mesh>(nutMesh(nutThread, 4e-3, 20e-3));
  // A whole number of pitches up, less the axial play, so that the flanks touch.
  const double start = 2e-3 - kPlay * std::tan(thread.flankAngle / 2);
  SceneDescription scene;
  for (std::size_t i = 0; i < frictions.size(); ++i) {
    addBody(scene, "bolt", meshNamed("bolt", bolt), Vec3(kApart * double(i), 0, 0),
            {0, frictions[i]}, trial);
    addBody(scene, "nut", meshNamed("nut", nut), Vec3(kApart * double(i), 0, start),
            springMatter(kMass, frictions[i], 1e4, 1), trial);
    // With an initial spin, only friction decides whether the nut stops.
    scene.bodies.back().angularVelocity = Vec3(0, 0, -kSpin);
    scene.bodies.back().linearVelocity = Vec3(0, 0, -kSpin * thread.lead() / (2 * kPi));
  }
  return scene;
}

Nuts tried(const Trial& trial, const std::vector<double>& frictions) {
  MovingWorld motion(sceneOf(trial, frictions), trial, kVoxel);
  // Right-handed: the nut turns backward on its way down, by much less than half a turn.
  const auto angle = [&](std::size_t nut) {
    const Vec3 x = motion.body(int(2 * nut + 1)).pose.orientation * Vec3::UnitX();
    return std::atan2(x.y(), x.x());
  };
  std::vector<double> before, start;
  for (std::size_t i = 0; i < frictions.size(); ++i)
    start.push_back(motion.body(int(2 * i + 1)).pose.position.z());
  motion.run(kSeconds * 2 / 3);
  for (std::size_t i = 0; i < frictions.size(); ++i) before.push_back(angle(i));
  motion.run(kSeconds);
  Nuts nuts;
  const double lead = threadFor(trial).lead();
  for (std::size_t i = 0; i < frictions.size(); ++i) {
    nuts.stayed.push_back(before[i] - angle(i) < 0.02);
    const double fell = start[i] - motion.body(int(2 * i + 1)).pose.position.z();
    const bool onThread = std::abs(fell + angle(i) * lead / (2 * kPi)) < 0.25 * lead;
    nuts.threaded = nuts.threaded && onThread;
  }
  return nuts;
}

// Clouds build their fields once per world and nuts cost little: one fine ladder of frictions.
// Peers pay for each nut and step: two rounds with three nuts each.
Verdict threshold(const Trial& trial) {
  if (trial.method == Method::Gjk) throw std::runtime_error("cannot: a nut's hull has no hole");
  const int arms = usesClouds(trial.method) ? 15 : 3;
  const int rounds = usesClouds(trial.method) ? 1 : 2;
  const double expected = theory(threadFor(trial));
  double low = rounds == 1 ? 0.5 * expected : 0, high = 2 * expected - low;
  for (int round = 0; round < rounds; ++round) {
    std::vector<double> frictions;
    for (int i = 1; i <= arms; ++i) frictions.push_back(low + (high - low) * i / (arms + 1));
    const Nuts nuts = tried(trial, frictions);
    if (!nuts.threaded) return {Outcome::Fails, 0, expected, "a nut leaves its thread"};
    for (int i = 0; i < arms; ++i) {
      if (nuts.stayed[std::size_t(i)]) {
        high = frictions[std::size_t(i)];
        break;
      }
      low = frictions[std::size_t(i)];
    }
  }
  const double found = (low + high) / 2;
  return within(found, expected, 0.1, found < expected ? "locks too early" : "locks too late");
}

}  // namespace screw

// --- A peg and a hole a little wider.

namespace peg {

constexpr double kRadius = 4e-3, kLength = 12e-3, kHeight = 8e-3, kWidth = 12e-3, kChamfer = 0.5e-3;
constexpr double kInside = 3e-3;  // initial depth in the hole
constexpr double kMass = 0.0047;  // steel
constexpr double kSeconds = 0.5;

// Fine enough for the peg's shape, and at most two clearances.
double voxelFor(double clearance) {
  return std::min(0.4e-3, 2 * clearance);
}

SceneDescription sceneOf(const Trial& trial, double clearance) {
  // HACD's time grows with the square of the triangles; 32 segments are within 0.02 mm of a circle.
  const int segments = usesClouds(trial.method) ? 192 : trial.method == Method::Hacd ? 32 : 96;
  SceneDescription scene;
  addPlane(scene, 0.1);
  addBody(scene, "hole",
          meshNamed("hole", std::make_shared<const Mesh>(holeMesh(kRadius + clearance, kWidth,
                                                                  kHeight, kChamfer, segments))),
          Vec3::Zero(), {0, 0.1}, trial);
  // Offset and tilted by about half of what the clearance allows at this depth.
  SceneBody& body = addBody(
      scene, "peg",
      meshNamed("peg", std::make_shared<const Mesh>(pegMesh(kRadius, kLength, kChamfer, segments))),
      Vec3(0.3 * clearance, -0.15 * clearance, kHeight - kInside),
      springMatter(kMass, 0.1, 2e4, 0.5), trial);
  const double tilt = std::min(0.02, 0.3 * clearance / kInside);
  body.pose.orientation = Eigen::AngleAxisd(tilt, Vec3(1, -0.5, 0).normalized());
  return scene;
}

Verdict goesIn(const Trial& trial, double clearance) {
  if (trial.method == Method::Gjk) throw std::runtime_error("cannot: a hole's hull is full");
  const double voxel = voxelFor(clearance);
  MovingWorld motion(sceneOf(trial, clearance), trial, voxel);
  motion.run(kSeconds);
  const double above = std::abs(motion.body(2).pose.position.z()) / voxel;
  return failIfGains(atMost(above, 0.5, "jams"), motion.gained(),
                     kMass * kGravity * (kHeight - kInside));
}

}  // namespace peg

// --- A pinion drives a wheel.

namespace gears {

constexpr double kVoxel = 0.6e-3, kSeconds = 2, kSpin = 15, kDensity = 7800;

SceneJoint axle(int body, const Vec3& position) {
  SceneJoint joint;
  joint.name = "axle";
  joint.kind = SceneJoint::Kind::Revolute;
  joint.child = body;
  joint.pose.position = position;
  return joint;
}

// The pinion's tooth on the x axis is in a gap of the wheel, which has an odd number of teeth.
SceneDescription sceneOf(const Trial& trial, const Gear& pinion, const Gear& wheel) {
  SceneDescription scene;
  scene.gravity = Vec3::Zero();
  double at = 0;
  for (const Gear& gear : {pinion, wheel}) {
    const double radius = gear.pitchRadius();
    const double mass = kPi * radius * radius * gear.width * kDensity;
    const std::string name = "gear" + std::to_string(gear.teeth);
    // Both state twice the pair's: two bodies press in series.
    addBody(scene, name, meshNamed(name, std::make_shared<const Mesh>(gearMesh(gear))),
            Vec3(at, 0, 0), {mass, 0.1, 2e5, 200}, trial);
    scene.joints.push_back(axle(int(scene.bodies.size()) - 1, Vec3(at, 0, 0)));
    at += pinion.pitchRadius() + wheel.pitchRadius();
  }
  scene.bodies[0].angularVelocity = Vec3(0, 0, kSpin);
  return scene;
}

// Accumulates a body's rotation about z, step by step.
struct Rotation {
  double last = 0, sum = 0;
  void add(double angle) {
    sum += std::remainder(angle - last, 2 * kPi);
    last = angle;
  }
};

Verdict keepRatio(const Trial& trial, double backlash) {
  if (trial.method == Method::Gjk) throw std::runtime_error("cannot: a gear's hull has no teeth");
  Gear pinion, wheel;
  wheel.teeth = 27;
  pinion.thinned = wheel.thinned = backlash / 2;
  MovingWorld motion(sceneOf(trial, pinion, wheel), trial, kVoxel);
  const double energy =
      0.5 * 0.5 * motion.world().mass(0) * std::pow(pinion.pitchRadius() * kSpin, 2);
  Rotation turned[2];
  double slip = 0;
  motion.run(kSeconds, [&] {
    for (int i = 0; i < 2; ++i) {
      const Vec3 x = motion.body(i).pose.orientation * Vec3::UnitX();
      turned[i].add(std::atan2(x.y(), x.x()));
    }
    slip = std::max(slip, std::abs(turned[0].sum * pinion.teeth + turned[1].sum * wheel.teeth));
    return false;
  });
  if (std::abs(turned[1].sum) < kPi) return {Outcome::Fails, 0, 1, "the teeth catch"};
  const double tooth = kPi * pinion.module;
  return failIfGains(atMost(slip / (2 * kPi), (backlash + kVoxel) / tooth, "teeth pass through"),
                     motion.gained(), energy);
}

}  // namespace gears

// --- A bowl slides to rest in a slightly larger bowl.

namespace bowls {

constexpr double kVoxel = 5e-3, kInner = 0.1, kWall = 0.015, kGap = 5e-3, kSeconds = 3, kMass = 0.5;

// Both are spherical, so their penetration follows from the distance of their centers.
Verdict staysIn(const Trial& trial) {
  if (trial.method == Method::Gjk) throw std::runtime_error("cannot: a bowl's hull is full");
  const int segments = usesClouds(trial.method) ? 96 : trial.method == Method::Hacd ? 16 : 32;
  const auto bowl = [&](const std::string& name, double inner) {
    return meshNamed(name, std::make_shared<const Mesh>(bowlMesh(inner, inner + kWall, segments)));
  };
  SceneDescription scene;
  addBody(scene, "large", bowl("large", kInner), Vec3::Zero(), {0, 0.1}, trial);
  const double low = 0.9 * kGap;
  SceneBody& small = addBody(scene, "small", bowl("small", kInner - kGap - kWall),
                             Vec3(0.3 * kGap, 0, -low), springMatter(kMass, 0.1, 1e4, 0.5), trial);
  small.pose.orientation = Eigen::AngleAxisd(0.5, Vec3(1, 2, 0).normalized());
  MovingWorld motion(scene, trial, kVoxel);
  double deepest = 0;
  motion.run(kSeconds, [&] {
    deepest = std::max(deepest, motion.body(1).pose.position.norm() - kGap);
    return false;
  });
  return failIfGains(atMost(deepest / kVoxel, 0.5, "goes through"), motion.gained(),
                     kMass * kGravity * kInner * (1 - std::cos(0.5)) / 2);
}

}  // namespace bowls

// --- Newton's cradle of five balls on springs.

namespace cradle {

constexpr int kBalls = 5;
constexpr double kRadius = 0.05, kString = 0.5, kLift = 0.3, kMass = 1, kStiffness = 1e4;
constexpr double kVoxel = 0.005, kSeconds = 0.8;

// One-dimensional model in double: equal masses in a row, a spring between neighbors, each step
// solved to convergence. Returns the last ball's maximum speed where the first arrives with
// `speed`, a `phase` of a step before it touches.
double lastSpeed(double speed, double step, double phase) {
  std::array<double, kBalls> x{}, v{};
  x[0] = -phase * speed * step;
  v[0] = speed;
  double most = 0;
  for (double time = 0; time < 0.3; time += step) {
    std::array<double, kBalls> impulse{};
    for (int i = 0; i < kBalls; ++i) v[i] -= step * kGravity / kString * x[i];
    // Gauss-Seidel: v includes the impulses so far; each sweep updates the springs in turn.
    for (int sweep = 0; sweep < 100; ++sweep)
      for (int i = 0; i + 1 < kBalls; ++i) {
        const double closing = v[i] - v[i + 1], stretch = step * step * kStiffness;
        const double without = closing + 2 * impulse[i] / kMass;
        const double now =
            std::max(0.0, (step * kStiffness * (x[i] - x[i + 1]) + stretch * without) /
                              (1 + 2 * stretch / kMass));
        v[i] -= (now - impulse[i]) / kMass;
        v[i + 1] += (now - impulse[i]) / kMass;
        impulse[i] = now;
      }
    for (int i = 0; i < kBalls; ++i) x[i] += step * v[i];
    most = std::max(most, v[kBalls - 1]);
  }
  return most;
}

SceneDescription sceneOf(const Trial& trial) {
  SceneDescription scene;
  for (int i = 0; i < kBalls; ++i) {
    const Vec3 pivot(2 * kRadius * i, 0, kString);
    const Eigen::AngleAxisd turn(i == 0 ? kLift : 0, Vec3::UnitY());
    const Vec3 place = pivot + turn * Vec3(0, 0, -kString);
    // Each states twice the pair's: two bodies press in series.
    addBody(scene, "ball" + std::to_string(i), ballFor(trial, kRadius), place,
            {kMass, 0, 2 * kStiffness, 0}, trial);
    SceneJoint hinge;
    hinge.name = "string" + std::to_string(i);
    hinge.kind = SceneJoint::Kind::Revolute;
    hinge.child = i;
    hinge.pose.position = pivot;
    hinge.axis = Vec3::UnitY();
    scene.joints.push_back(hinge);
  }
  return scene;
}

Verdict passesOn(const Trial& trial) {
  MovingWorld motion(sceneOf(trial), trial, kVoxel);
  double first = 0, last = 0;
  motion.run(kSeconds, [&] {
    first = std::max(first, motion.body(0).linearVelocity.x());
    last = std::max(last, motion.body(kBalls - 1).linearVelocity.x());
    return false;
  });
  // The phase is not known: take the nearest prediction of all phases.
  double expected = 0;
  for (double phase = 0; phase < 1; phase += 0.125) {
    const double share = lastSpeed(first, trial.step, phase) / first;
    if (std::abs(share - last / first) < std::abs(expected - last / first)) expected = share;
  }
  return failIfGains(within(last / first, expected, 0.05, "differs from the springs' recurrence"),
                     motion.gained(), kMass * first * first / 2);
}

}  // namespace cradle

using enum Method;

std::vector<StabilityScene> inclines() {
  const std::vector<Method> methods = {Cloud, Paper, Primitive, Gimpact};
  const std::vector<double> steps = {kStep240, kStep60, kStep1000};
  return {{"incline at friction 0.49",
           "mechanisms",
           "on a slope of 0.5 a brick slides as far as g (sin - mu cos) t^2 / 2, within 20 % [m]",
           methods,
           steps,
           {"stiff", "auto"},
           0.3,
           incline::slides},
          {"incline at friction 0.50",
           "mechanisms",
           "on a slope of 0.5 a brick stands for 2 s: distance, relative to that at 0.49 [%]",
           methods,
           steps,
           {"stiff", "auto"},
           0.3,
           incline::stands}};
}

std::vector<StabilityScene> pegs() {
  std::vector<StabilityScene> scenes;
  for (const auto& [clearance, name] :
       {std::pair(1e-3, "1"), {0.5e-3, "0.5"}, {0.2e-3, "0.2"}, {0.1e-3, "0.1"}, {0.05e-3, "0.05"}})
    scenes.push_back(
        {std::string("peg in hole, clearance ") + name + " mm",
         "mechanisms",
         "an 8 mm peg reaches the floor through a hole whose radius is larger by the clearance "
         "(half a voxel, from 0.2 mm down): height above the floor [voxels]",
         {Cloud, Paper, Gimpact, Hacd, Gjk},
         {kStep240, kStep60, kStep1000},
         {"stiff", "auto"},
         clearance < 0.2e-3 ? 3.0 : 1.0,
         [clearance = clearance](const Trial& trial) { return peg::goesIn(trial, clearance); },
         clearance == 0.1e-3});
  return scenes;
}

}  // namespace

std::vector<StabilityScene> mechanismScenes() {
  std::vector<StabilityScene> scenes = inclines();
  scenes.push_back(
      {"screw's self-locking",
       "mechanisms",
       "a turning nut stops above the friction tan(lead angle) cos(half flank angle), within 10 %",
       {Cloud, Paper, Gimpact, Gjk},
       {kStep1000, kStep240},
       {"stiff", "auto"},
       15,
       screw::threshold});
  for (const StabilityScene& scene : pegs()) scenes.push_back(scene);
  for (const auto& [backlash, name] :
       {std::pair(0.8e-3, "gear pair"), {0.3e-3, "gear pair, backlash of half a voxel"}})
    scenes.push_back(
        {name,
         "mechanisms",
         "18 teeth drive 27 by at least half a turn: slip of at most the backlash and a voxel "
         "[teeth]",
         {Cloud, Paper, Gimpact, Gjk},
         {kStep1000, kStep240},
         {"stiff", "auto"},
         6,
         [backlash = backlash](const Trial& trial) { return gears::keepRatio(trial, backlash); }});
  scenes.push_back({"bowl in bowl",
                    "mechanisms",
                    "a bowl released at 29 deg in one 5 mm larger: maximum penetration [voxels]",
                    {Cloud, Paper, Gimpact, Hacd, Gjk},
                    {kStep240, kStep60, kStep1000},
                    {"stiff", "auto"},
                    1,
                    bowls::staysIn});
  scenes.push_back({"Newton's cradle",
                    "mechanisms",
                    "of five balls the last leaves with the share of the first's speed that the "
                    "springs' recurrence gives, within 5 %",
                    {Cloud, Paper, Primitive},
                    {kStep1000, kStep240},
                    {"stiff"},
                    1,
                    cradle::passesOn});
  return scenes;
}

}  // namespace cloudcontact::program::lab
