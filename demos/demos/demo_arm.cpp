// The demo `arm`: an arm of six joints puts a peg into a hole that is not quite where the arm
// believes.
//
// The arm feels no hole. Its joints push by torques that are those of a spring at the peg's end
// (impedance, N. Hogan, J. Dyn. Sys. Meas. Control 107, 1985): tau = J^T (K e) + what holds the
// links' weight, with dampers in the joints. What is soft gives way, and the chamfers and walls
// turn the peg into the hole.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>

#include "demos/demo.h"
#include "draw/wrench_chart.h"
#include "io/progress.h"
#include "replay/embedded.h"
#include "scene/generated_mesh.h"
#include "scene/shape_store.h"

namespace cloudcontact::program {
namespace arm {

constexpr double kVoxel = 0.1e-3, kStep = 1e-3, kSeconds = 3;
constexpr double kPegRadius = 4e-3, kHoleRadius = 4.05e-3, kChamfer = 0.5e-3;
constexpr double kHeight = 12e-3;  // of the block
constexpr double kStart = 4e-3;    // of the peg's end above it
constexpr double kBeyond = 3e-3;   // of the goal below the floor, which the peg presses
constexpr double kFriction = 0.1;
constexpr double kPush = 3000, kTurn = 1;  // of the peg's end [N/m, N m/rad]
constexpr int kBeliefs = 50;
constexpr double kOff = 0.5e-3, kTilt = 2 * std::numbers::pi / 180;
const Vec3 kMouth(0.4, 0, kHeight);
const Vec3 kPegInTool(0, 0, -0.12);  // its end

struct Link {
  const char *joint, *body;
  double damping;  // [N m s/rad]
};
constexpr Link kLinks[6] = {{"turn", "turret", 20}, {"shoulder", "upper", 20},
                            {"elbow", "fore", 10},  {"forearm", "roll", 0.05},
                            {"bend", "wrist", 0.1}, {"flange", "tool", 0.02}};

SceneDescription scene(const DemoStage& stage) {
  SceneDescription scene = stage.readRobot("arm", std::string(embedded::arm_urdf()));
  scene.name = "arm";
  scene.gravity = Vec3(0, 0, -9.81);
  scene.step = kStep;
  for (SceneBody& body : scene.bodies) {
    body.friction = kFriction;
    if (!body.name.ends_with("tool")) continue;
    body.collisions = {{"peg", Pose{Eigen::Quaterniond::Identity(), kPegInTool},
                        SceneMesh{"peg", Vec3::Ones(),
                                  std::make_shared<Mesh>(pegMesh(kPegRadius, 20e-3, kChamfer))}}};
  }
  const DemoMatter fixed{0, kFriction, {}, {}};
  const Pose below{Eigen::Quaterniond::Identity(), Vec3(kMouth.x(), kMouth.y(), 0)};
  scene.bodies.push_back(demoFloor(kFriction));
  scene.bodies.push_back(demoBody(
      "hole", "hole", std::make_shared<Mesh>(holeMesh(kHoleRadius, 14e-3, kHeight, kChamfer)),
      below, fixed));
  for (int i : {2, 1}) scene.bodies[scene.bodies.size() - i].model = 100 - i;
  return scene;
}

// Where the arm believes the hole's mouth.
struct Belief {
  Vec3 off = Vec3::Zero();
  Eigen::Quaterniond tilt = Eigen::Quaterniond::Identity();
  // Of the peg's end: it waits over the mouth, goes down, and presses.
  Pose goal(double time) const {
    const double down = std::clamp((time - 0.3) / 1.2, 0.0, 1.0);
    const double height = kStart - down * (kStart + kHeight + kBeyond);
    return {tilt, kMouth + off + tilt * Vec3(0, 0, height)};
  }
};

std::vector<Belief> beliefs() {
  std::mt19937 random(6);
  const auto share = [&] { return random() / 4294967296.0; };
  const auto around = [&] {
    const double angle = 2 * std::numbers::pi * share();
    return Vec3(std::cos(angle), std::sin(angle), 0);
  };
  std::vector<Belief> all(kBeliefs);
  for (Belief& belief : all) {
    belief.off = kOff * std::sqrt(share()) * around();
    belief.tilt = Eigen::AngleAxisd(kTilt * std::sqrt(share()), around());
  }
  return all;
}

class Arm {
 public:
  // The scene has all of the names.
  explicit Arm(const World& world) : gravity_(9.81) {
    for (int i = 0; i < 6; ++i) {
      std::size_t &body = bodies_[i], &joint = joints_[i];
      while (world.name(body) != std::string("arm::") + kLinks[i].body) ++body;
      while (world.describedJoint(joint).name != std::string("arm::") + kLinks[i].joint) ++joint;
    }
  }
  Pose end(const World& world) const {
    return world.pose(bodies_[5]) * Pose{Eigen::Quaterniond::Identity(), kPegInTool};
  }
  double speed(const World& world) const { return world.state(bodies_[5]).linearVelocity.norm(); }
  JointState flange(const World& world) const { return world.joint(joints_[5]); }

  // Torques of a spring that pulls the peg's end to `goal`, which goes on at `velocity`. The
  // joints' dampers resist what is not that motion.
  void pull(World& world, const Pose& goal, const Vec3& velocity) const {
    const Pose now = end(world);
    Eigen::Matrix<double, 6, 6> jacobian;  // from the joints' speeds to the end's
    for (int i = 0; i < 6; ++i)
      jacobian.col(i) << axis(world, i).cross(now.position - world.joint(joints_[i]).origin),
          axis(world, i);
    Eigen::Matrix<double, 6, 1> wanted = Eigen::Matrix<double, 6, 1>::Zero();
    wanted.head<3>() = velocity;
    const Eigen::Matrix<double, 6, 1> speeds = jacobian.fullPivLu().solve(wanted);
    const Eigen::AngleAxisd turn(goal.orientation * now.orientation.conjugate());
    const Vec3 force = kPush * (goal.position - now.position),
               torque = kTurn * turn.angle() * turn.axis();
    for (int i = 0; i < 6; ++i)
      world.setMotor(joints_[i], 0,
                     {.velocity = speeds[i],
                      .damping = kLinks[i].damping,
                      .force = hold(world, i) + about(world, i, now.position, force) +
                               axis(world, i).dot(torque)});
  }

  // Torques: J^T of the wrench that the contacts push with, and what the joints carry beside the
  // links' weight, which is the opposite in equilibrium.
  struct Torques {
    Eigen::Matrix<double, 6, 1> pushed = Eigen::Matrix<double, 6, 1>::Zero(), carried = pushed;
  };
  void addTo(Torques& sums, const World& world) const {
    ContactsNow now;
    world.contacts(now);
    for (int i = 0; i < 6; ++i) {
      for (const PatchNow& patch : now.patches)
        for (const ContactNow& point : now.of(patch)) {
          const double side = patch.b == int(bodies_[5]) ? 1 : patch.a == int(bodies_[5]) ? -1 : 0;
          sums.pushed[i] += about(world, i, point.position, side * point.force);
        }
      sums.carried[i] += axis(world, i).dot(world.joint(joints_[i]).torque) - hold(world, i);
    }
  }

 private:
  Vec3 axis(const World& world, int i) const { return world.axis(joints_[i], 0).direction; }
  // The torque of a force about a joint.
  double about(const World& world, int i, const Vec3& at, const Vec3& force) const {
    return axis(world, i).dot((at - world.joint(joints_[i]).origin).cross(force));
  }
  // What holds the weight of the links behind a joint.
  double hold(const World& world, int i) const {
    double sum = 0;
    for (int link = i; link < 6; ++link) {
      const SceneBody& body = world.described(bodies_[link]);
      const Vec3 center = world.pose(bodies_[link]).toWorld(body.inertialPose->position);
      sum += about(world, i, center, Vec3(0, 0, *body.mass * gravity_));
    }
    return sum;
  }

  double gravity_;
  std::size_t bodies_[6] = {}, joints_[6] = {};
};

void follow(const Arm& arm, World& world, const Belief& belief, double time) {
  const Pose goal = belief.goal(time);
  arm.pull(world, goal, (belief.goal(time + kStep).position - goal.position) / kStep);
}

// The end of a start.
struct Outcome {
  bool isIn = false;
  double imbalance = 1;  // of the torques, as a part of them
  double hardest = 0;    // push at the flange [N]
};

// The hole itself lets the peg tilt by 0.5 deg.
bool isIn(const Arm& arm, const World& world) {
  const Pose end = arm.end(world);
  const double tilt = std::acos(std::min(1.0, (end.orientation * Vec3::UnitZ()).z()));
  return std::abs(end.position.z()) < 0.05e-3 && tilt < 0.7 * std::numbers::pi / 180 &&
         arm.speed(world) < 1e-3;
}

// All beliefs, each from the same state.
std::vector<Outcome> tryAll(World& world) {
  const Arm arm(world);
  const WorldSave start = world.save();
  const auto progress = progressBar("simulating the other starts");
  std::vector<Outcome> all;
  for (const Belief& belief : beliefs()) {
    world.restore(start);
    Outcome outcome;
    Arm::Torques torques;  // of the last tenth of a second
    for (int n = 0; n < std::lround(kSeconds / kStep); ++n) {
      follow(arm, world, belief, n * kStep);
      world.step(kStep);
      outcome.hardest = std::max(outcome.hardest, arm.flange(world).force.norm());
      if (n * kStep > kSeconds - 0.1) arm.addTo(torques, world);
    }
    outcome.isIn = isIn(arm, world);
    if (const double pushed = torques.pushed.norm(); pushed > 0)
      outcome.imbalance = (torques.pushed + torques.carried).norm() / pushed;
    all.push_back(outcome);
    if (progress) progress(double(all.size()) / kBeliefs);
  }
  return all;
}

}  // namespace arm

std::vector<ReplayCheck> runArm(DemoStage& stage) {
  using namespace arm;
  const SceneDescription made = scene(stage);
  WorldSettings settings = demoSettings(kVoxel);
  settings.store = std::make_shared<ShapeStore>();
  SimulationSettings run;
  run.seconds = kSeconds;
  run.step = kStep;
  run.instants = 20;
  const Belief first = beliefs().front();
  std::optional<Arm> known;
  run.control = [&](double time, World& world) {
    if (!known) known.emplace(world);
    follow(*known, world, first, time);
  };
  std::vector<WrenchAt> wrenches;
  run.observe = [&](double time, const World& world) {
    if (!known) known.emplace(world);
    const JointState flange = known->flange(world);
    wrenches.push_back({time, flange.force, flange.torque});
  };
  const SimulationReport report = stage.run(made, settings, run, "");
  if (stage.isShort()) return {};
  if (stage.wantsPictures())
    stage.addPicture("arm_wrench", std::make_shared<const Drawing>(wrenchChart(
                                       wrenches, "What the flange carries as the peg goes in",
                                       "Of the link before it on the tool, in the world's axes, "
                                       "about the flange; the tool weighs 3.9 N")));
  World world(made, settings);
  const std::vector<Outcome> all = tryAll(world);
  const auto in = std::count_if(all.begin(), all.end(), [](const Outcome& o) { return o.isIn; });
  double off = 0, hardest = 0;
  for (const Outcome& o : all)
    off = std::max(off, o.imbalance), hardest = std::max(hardest, o.hardest);
  return {{"the peg comes home from all 50 beliefs", std::to_string(in), in == kBeliefs},
          {"joint torques are J^T of the contacts' wrench within 1 %", figure(100 * off, 3, "%"),
           off < 0.01},
          {"nothing pushes harder than 60 N", figure(hardest, 1, "N"), hardest < 60},
          {"it never overlaps by over half a voxel", figure(1e3 * report.maxPenetration, 4, "mm"),
           report.maxPenetration < kVoxel / 2}};
}

}  // namespace cloudcontact::program
