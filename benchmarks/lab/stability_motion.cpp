// Motion whose energy, speed or end is known: rolling, spinning, bouncing, tipping, impact, rest.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "lab/trial_runs.h"

namespace cloudcontact::program::lab {
namespace {

constexpr double kPi = std::numbers::pi;
using enum Method;

// --- A ball and a cylinder roll along a table.

namespace rolling {

constexpr double kRadius = 0.2, kSpeed = 1, kVoxel = 0.01, kSeconds = 3, kMass = 1;

Verdict keepsSpeed(const Trial& trial, bool cylinder) {
  // Sag 0.1 voxel. A rolling body is compressed in front and released behind, where damping takes
  // energy; so the damping is low.
  const Matter matter = springMatter(kMass, 0.5, 9800, 0.2);
  SceneDescription scene;
  addBody(scene, "table", boxFor(trial, Vec3(4, 0.6, 0.1)), Vec3(1.5, 0, -0.05), {0, 0.5}, trial);
  const auto shape = cylinder ? cylinderFor(trial, kRadius, 0.2) : ballFor(trial, kRadius);
  const double height = kRadius - sagOf(trial, matter, kMass * kGravity, kVoxel);
  SceneBody& body = addBody(scene, "roller", shape, Vec3(0, 0, height), matter, trial);
  if (cylinder) body.pose.orientation = Eigen::AngleAxisd(kPi / 2, Vec3::UnitX());
  body.linearVelocity = Vec3(kSpeed, 0, 0);
  body.angularVelocity = Vec3(0, kSpeed / kRadius, 0);
  MovingWorld motion(scene, trial, kVoxel);
  motion.run(kSeconds);
  const double lost = 100 * (1 - motion.body(1).linearVelocity.x() / kSpeed);
  return failIfGains(atMost(lost, 1, "slows down"), motion.gained(), kMass * kSpeed * kSpeed / 2);
}

}  // namespace rolling

// --- A top spins on a round tip, slightly tilted.

namespace top {

constexpr double kVoxel = 0.01, kSeconds = 3, kSpin = 80, kMass = 1, kFriction = 0.3;
constexpr double kTip = 0.03, kDisc = 0.15, kTilt = 0.1;

SceneDescription sceneOf(const Trial& trial, const Matter& matter) {
  SceneDescription scene;
  addPlane(scene, kFriction);
  SceneBody& body = addBody(scene, "top", ballFor(trial, kTip), Vec3::Zero(), matter, trial);
  body.collisions[0].pose.position = Vec3(0, 0, kTip);
  const auto add = [&](const char* name, double radius, double length, double z) {
    body.collisions.push_back({name,
                               {Eigen::Quaterniond::Identity(), Vec3(0, 0, z)},
                               cylinderFor(trial, radius, length)});
  };
  add("stem", 0.02, 0.11, 0.085);
  add("disc", kDisc, 0.03, 0.15);
  body.pose.orientation = Eigen::AngleAxisd(kTilt, Vec3::UnitX());
  body.pose.position.z() =
      kTip * (1 - std::cos(kTilt)) - sagOf(trial, matter, kMass * kGravity, kVoxel);
  body.angularVelocity = kSpin * (body.pose.orientation * Vec3::UnitZ());
  return scene;
}

// Friction brakes the spin with at most mu m g on a lever: two thirds of the contact's radius for
// drilling, plus the tip's radius times the sine of the tilt for slipping.
Verdict keepsSpin(const Trial& trial) {
  const Matter matter = springMatter(kMass, kFriction, 2e4, 1);
  MovingWorld motion(sceneOf(trial, matter), trial, kVoxel);
  double tilt = kTilt;
  motion.run(kSeconds, [&] {
    const Vec3 axis = motion.body(1).pose.orientation * Vec3::UnitZ();
    tilt = std::max(tilt, std::acos(std::min(1.0, axis.z())));
    return false;
  });
  if (tilt > 1) return {Outcome::Fails, 1, 1, "falls over"};
  const double sag = std::max(sagOf(trial, matter, kMass * kGravity, kVoxel), 1e-3 * kVoxel);
  const double arm = 2.0 / 3 * std::sqrt(2 * kTip * sag) + kTip * std::sin(tilt);
  const double inertia = 0.5 * kMass * kDisc * kDisc;  // mostly the disc's
  const double mayLose = kFriction * kMass * kGravity * arm / inertia * kSeconds;
  const BodyState end = motion.body(1);
  const double lost = kSpin - end.angularVelocity.dot(end.pose.orientation * Vec3::UnitZ());
  return failIfGains(atMost(lost / mayLose, 1, "loses more spin than friction can remove"),
                     motion.gained(), inertia * kSpin * kSpin / 2);
}

}  // namespace top

// --- A ball bounces as the recurrence of its spring and damper predicts.

namespace bouncing {

constexpr double kVoxel = 0.01, kRadius = 0.1, kGap = 0.5, kMass = 1, kStiffness = 2.5e4;

struct Speeds {
  double down = 0, up = 0;
  void add(double speed) {
    down = std::max(down, -speed);
    up = std::max(up, speed);
  }
};

// The law as the solver steps it: impulse = step (k d+ + c v+), d+ = d + step v+, at least 0. In
// the step of the impact only the part inside counts; contacts within Bullet's threshold are known
// before. Backward Euler dissipates energy: at 60 Hz nearly all.
Speeds recurrence(const Matter& matter, double step, double seconds) {
  constexpr double kSeen = 0.02;  // gContactBreakingThreshold [m]
  Speeds speeds;
  double gap = kGap, speed = 0;
  for (double time = 0; time < seconds; time += step) {
    const double free = speed - step * kGravity;
    const double grip = step * (matter.damping + step * matter.stiffness);
    const double push =
        gap > 0 ? -grip * (free + gap / step) : -step * matter.stiffness * gap - grip * free;
    const double impulse = gap < kSeen ? std::max(0.0, push / (1 + grip / matter.mass)) : 0;
    speed = free + impulse / matter.mass;
    gap += step * speed;
    speeds.add(speed);
  }
  return speeds;
}

Verdict rebounds(const Trial& trial, double ratio) {
  const Matter matter = springMatter(kMass, 0.5, kStiffness, ratio);
  SceneDescription scene;
  addBody(scene, "floor", boxFor(trial, Vec3(0.6, 0.6, 0.2)), Vec3(0, 0, -0.1), {0, 0.5}, trial);
  addBody(scene, "ball", ballFor(trial, kRadius), Vec3(0, 0, kRadius + kGap), matter, trial);
  MovingWorld motion(scene, trial, kVoxel);
  const double seconds = 0.6;
  Speeds speeds;
  motion.run(seconds, [&] {
    speeds.add(motion.body(1).linearVelocity.z());
    return false;
  });
  const Speeds law = recurrence(matter, trial.step, seconds);
  const double found = speeds.up / speeds.down, expected = law.up / law.down;
  return failIfGains(within(found, expected, 0.05, "differs from the law's recurrence"),
                     motion.gained(), kMass * kGravity * kGap);
}

}  // namespace bouncing

// --- A box overhangs a table's edge. It should tip when its center passes the edge.

namespace edge {

constexpr double kVoxel = 0.02, kSeconds = 2.5, kMass = 1;

bool stays(const Trial& trial, double beyond) {
  // Sag 0.01 voxel: on a soft spring the box would lean out before it tips.
  const Matter matter = springMatter(kMass, 0.5, 4.9e4, 1);
  SceneDescription scene;
  addBody(scene, "table", boxFor(trial, Vec3(0.6, 0.6, 0.1)), Vec3(-0.3, 0, -0.05), {0, 0.5},
          trial);
  const double sag = sagOf(trial, matter, kMass * kGravity, kVoxel);
  addBody(scene, "box", boxFor(trial, Vec3(0.4, 0.4, 0.1)), Vec3(beyond, 0, 0.05 - sag), matter,
          trial);
  MovingWorld motion(scene, trial, kVoxel);
  const auto tipped = [&] {
    return (motion.body(1).pose.orientation * Vec3::UnitZ()).z() < std::cos(0.1);
  };
  motion.run(kSeconds, tipped);
  return !tipped();
}

Verdict tips(const Trial& trial) {
  const double reach = 4 * kVoxel;
  const double found = turningPoint(-reach, reach, 7, [&](double x) { return stays(trial, x); });
  return atMost(std::abs(found) / kVoxel, 0.5, found < 0 ? "tips early" : "tips late");
}

}  // namespace edge

// --- A bullet hits a thin wall. At which speed does it tunnel?

namespace bullet {

constexpr double kVoxel = 0.01, kWall = 0.04, kRadius = 0.03, kMass = 0.1;
constexpr int kPhases = 3;  // of a step, at impact
constexpr double kRow = 0.2;

// Each bullet has its own wall, all in one world.
SceneDescription sceneOf(const Trial& trial, const std::vector<double>& shares) {
  SceneDescription scene;
  scene.gravity = Vec3::Zero();
  const auto wall = boxFor(trial, Vec3(kWall, 0.14, 0.14)), ball = ballFor(trial, kRadius);
  for (std::size_t i = 0; i < shares.size() * kPhases; ++i) {
    const double way = shares[i / kPhases] * kWall, phase = double(i % kPhases) / kPhases;
    const Vec3 place(0, kRow * double(i), 0);
    addBody(scene, "wall", wall, place, {0, 0.5}, trial);
    const Vec3 before((kWall / 2 + kRadius) + way * (1 + phase), 0, 0);
    SceneBody& body =
        addBody(scene, "bullet", ball, place - before, springMatter(kMass, 0.5, 1e6, 0.5), trial);
    body.linearVelocity = Vec3(way / trial.step, 0, 0);
  }
  return scene;
}

// Per speed: whether no bullet's center passes the middle of its wall, at any phase of impact.
std::vector<bool> held(const Trial& trial, const std::vector<double>& shares) {
  MovingWorld motion(sceneOf(trial, shares), trial, kVoxel);
  for (int step = 0; step < 30; ++step) motion.step();
  std::vector<bool> hold(shares.size(), true);
  for (std::size_t i = 0; i < shares.size() * kPhases; ++i)
    if (motion.body(int(2 * i + 1)).pose.position.x() > 0) hold[i / kPhases] = false;
  return hold;
}

// Each round tests several speeds at once.
Verdict tunnels(const Trial& trial) {
  constexpr int kArms = 7;
  double low = 0, high = 4;
  for (int round = 0; round < 3; ++round) {
    std::vector<double> shares;
    for (int i = 1; i <= kArms; ++i) shares.push_back(low + (high - low) * i / (kArms + 1));
    const std::vector<bool> hold = held(trial, shares);
    const auto through = std::size_t(std::find(hold.begin(), hold.end(), false) - hold.begin());
    if (through < shares.size()) high = shares[through];
    if (through > 0) low = shares[through - 1];
  }
  return atLeast((low + high) / 2, 0.5, "tunnels");
}

}  // namespace bullet

// --- A sheet of two voxels carries a box and a ball on either side, at any offset of the grid. For
// the lower side gravity points up.

namespace sheet {

constexpr double kVoxel = 0.02, kThick = 2 * kVoxel, kSeconds = 1.5, kMass = 1, kHalf = 0.1;

double sunk(const Trial& trial, double side, double phase) {
  const Matter matter = springMatter(kMass, 0.5, 4900, 1);
  const double sag = sagOf(trial, matter, kMass * kGravity, kVoxel);
  SceneDescription scene;
  scene.gravity = Vec3(0, 0, -side * kGravity);
  SceneBody& plate = addBody(scene, "plate", boxFor(trial, Vec3(1, 0.6, kThick)),
                             Vec3(0, 0, -phase), {0, 0.5}, trial);
  plate.collisions[0].pose.position.z() = phase;  // the grid is aligned with the body's origin
  const double height = side * (kThick / 2 + kHalf - sag);
  addBody(scene, "box", boxFor(trial, Vec3::Constant(2 * kHalf)), Vec3(-0.25, 0, height), matter,
          trial);
  addBody(scene, "ball", ballFor(trial, kHalf), Vec3(0.25, 0, height), matter, trial);
  MovingWorld motion(scene, trial, kVoxel);
  double worst = 0;
  motion.run(kSeconds, [&] {
    for (int i = 1; i <= 2; ++i)
      worst = std::max(worst, std::abs(motion.body(i).pose.position.z() - height));
    return false;
  });
  return worst;
}

Verdict carries(const Trial& trial) {
  double worst = 0;
  for (const double side : {1, -1})
    for (const double phase : {0.0, 0.3 * kVoxel, 0.5 * kVoxel})
      worst = std::max(worst, sunk(trial, side, phase));
  return atMost(worst / kVoxel, 0.5, "does not carry");
}

}  // namespace sheet

// --- A dropped box must not gain energy.

namespace drop {

constexpr double kVoxel = 0.02, kSeconds = 1.5, kMass = 1, kEdge = 0.2, kHeight = 0.4;

Verdict gainsNothing(const Trial& trial, const Vec3& turn, bool overEdge) {
  const Matter matter = springMatter(kMass, 0.5, 2e4, 0.3);
  SceneDescription scene;
  addBody(scene, "table", boxFor(trial, Vec3(1, 1, 0.2)), Vec3(overEdge ? -0.47 : 0, 0, -0.1),
          {0, 0.5}, trial);
  SceneBody& body = addBody(scene, "box", boxFor(trial, Vec3::Constant(kEdge)), Vec3(0, 0, kHeight),
                            matter, trial);
  body.pose.orientation = Eigen::AngleAxisd(turn.norm(), turn.normalized());
  MovingWorld motion(scene, trial, kVoxel);
  motion.run(kSeconds);
  if (!overEdge && motion.body(1).pose.position.z() < 0.4 * kEdge)
    return {Outcome::Fails, 0, 0.1, "falls through"};
  const double scale = kMass * kGravity * (kHeight - kEdge / 2);
  return atMost(100 * motion.gained() / scale, 0.1, "gains energy");
}

std::vector<StabilityScene> scenes() {
  struct Fall {
    const char* name;
    Vec3 turn;
    bool overEdge = false;
  };
  const double quarter = kPi / 4, corner = std::acos(1 / std::sqrt(3.0));
  const Fall falls[] = {{"box dropped on an edge", Vec3(quarter, 0, 0)},
                        {"box dropped on a corner", corner * Vec3(1, -1, 0).normalized()},
                        {"box dropped askew", Vec3(0.3, 0.6, 0.4)},
                        {"box dropped on a table's edge", Vec3(0.2, 0.4, 0.1), true}};
  std::vector<StabilityScene> scenes;
  for (const Fall& fall : falls)
    scenes.push_back(
        {fall.name,
         "motion",
         "no energy gained: gain relative to the fall's energy [%]",
         {Cloud, Paper, Primitive, Gimpact, Gjk},
         {kStep240, kStep60, kStep1000},
         {"stiff", "auto"},
         0.3,
         [fall](const Trial& trial) { return gainsNothing(trial, fall.turn, fall.overEdge); }});
  return scenes;
}

}  // namespace drop

const std::vector<double> kAllSteps = {kStep240, kStep60, kStep1000};
const std::vector<std::string> kBothModes = {"stiff", "auto"};

void addRollingAndSpinning(std::vector<StabilityScene>& scenes) {
  for (const bool cylinder : {false, true})
    scenes.push_back(
        {cylinder ? "rolling cylinder" : "rolling ball",
         "motion",
         "rolls for 3 s on a table: speed lost [%]",
         {Cloud, Paper, Primitive, Gimpact},
         kAllSteps,
         kBothModes,
         0.5,
         [cylinder](const Trial& trial) { return rolling::keepsSpeed(trial, cylinder); }});
  scenes.push_back({"spinning top",
                    "motion",
                    "spins for 3 s: spin lost, as a share of what friction can take",
                    {Cloud, Paper, Primitive, Gimpact},
                    kAllSteps,
                    kBothModes,
                    0.5,
                    top::keepsSpin});
}

void addHits(std::vector<StabilityScene>& scenes) {
  for (const auto& [name, ratio] :
       {std::pair("bouncing, undamped", 0.0), {"bouncing, damping ratio 0.2", 0.2}})
    scenes.push_back(
        {name,
         "motion",
         "speed after / speed before impact equals the law's recurrence, within 5 %",
         {Cloud, Paper, Primitive},
         {kStep1000, kStep240, kStep60},
         {"stiff"},
         0.3,
         [ratio = ratio](const Trial& trial) { return bouncing::rebounds(trial, ratio); }});
  scenes.push_back(
      {"bullet at a thin wall",
       "motion",
       "a ball of 3 voxels at a wall of 4: speed at which it tunnels, at least half [speed x "
       "step / thickness]",
       {Cloud, Paper, Primitive, Gimpact},
       kAllSteps,
       kBothModes,
       1,
       bullet::tunnels});
}

void addResting(std::vector<StabilityScene>& scenes) {
  scenes.push_back({"over a table's edge",
                    "motion",
                    "a box tips when its center passes the edge: error [voxels]",
                    {Cloud, Paper, Primitive, Gimpact, Gjk},
                    kAllSteps,
                    kBothModes,
                    1,
                    edge::tips});
  scenes.push_back({"sheet of 2 voxels",
                    "motion",
                    "carries a box and a ball on either side, at any grid offset: displacement "
                    "[voxels]",
                    {Cloud, Paper, Primitive, Gimpact},
                    kAllSteps,
                    kBothModes,
                    1,
                    sheet::carries});
}

}  // namespace

std::vector<StabilityScene> motionScenes() {
  std::vector<StabilityScene> scenes;
  addRollingAndSpinning(scenes);
  addHits(scenes);
  addResting(scenes);
  for (const StabilityScene& scene : drop::scenes()) scenes.push_back(scene);
  return scenes;
}

}  // namespace cloudcontact::program::lab
