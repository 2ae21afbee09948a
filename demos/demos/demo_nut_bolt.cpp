// The demo `nut_bolt`: friction decides whether a nut turns on its bolt.
#include <cmath>
#include <numbers>

#include "demos/demo.h"
#include "scene/generated_mesh.h"

namespace cloudcontact::program {
namespace nut_bolt {

constexpr double kVoxel = 0.25e-3;  // [m]
constexpr double kStep = 1.0 / 960;
constexpr double kSeconds = 1.2;
constexpr double kStart = 16e-3;  // of the nut's lower face, a multiple of the pitch [m]
constexpr double kLoose = 0.01,
                 kTight = 0.3;  // friction; an M16 thread is self-locking from about 0.037

SceneDescription scene(const Thread& thread, double friction) {
  Thread nutThread = thread;
  nutThread.clearance = 0.1e-3;
  SceneDescription scene;
  scene.name = "nut_bolt";
  scene.step = kStep;
  scene.bodies = {
      demoBody("bolt", "bolt", std::make_shared<Mesh>(boltMesh(thread, 32e-3, 24e-3, 10e-3)),
               Pose(), {0, friction, 2e4, 72}),
      demoBody("nut", "nut", std::make_shared<Mesh>(nutMesh(nutThread, 13e-3, 24e-3)),
               {Eigen::Quaterniond::Identity(), Vec3(0, 0, kStart)}, {0.0324, friction, 2e4, 72})};
  scene.bodies[1].model = 1;
  return scene;
}

SimulationReport fall(DemoStage& stage, const Thread& thread, double friction) {
  SimulationSettings settings;
  settings.seconds = kSeconds;
  settings.step = kStep;
  settings.instants = 10;
  return stage.run(scene(thread, friction), demoSettings(kVoxel), settings,
                   "friction " + figure(friction, 2));
}

}  // namespace nut_bolt

std::vector<ReplayCheck> runNutBolt(DemoStage& stage) {
  using namespace nut_bolt;
  const Thread thread;
  const SimulationReport loose = fall(stage, thread, kLoose);
  const double turns = loose.turns[1].z() / (2 * std::numbers::pi);
  const double perTurn = (loose.bodies[1].pose.position.z() - kStart) / turns;
  const SimulationReport tight = fall(stage, thread, kTight);
  const double held = std::abs(tight.turns[1].z()) / (2 * std::numbers::pi);
  const double deepest = std::max(loose.maxPenetration, tight.maxPenetration);
  return {
      {"at friction 0.01 the nut turns down by more than a turn", figure(-turns, 2, "turns"),
       turns < -1},
      {"falling 2 mm per turn within 3 %", figure(1e3 * perTurn, 3, "mm per turn"),
       std::abs(perTurn - thread.lead()) < 0.03 * thread.lead()},
      {"at friction 0.3 it stays within a twentieth of a turn", figure(held, 4, "turns"),
       held < 0.05},
      {"threads never overlap by over 0.1 mm", figure(1e3 * deepest, 3, "mm"), deepest < 0.1e-3}};
}

}  // namespace cloudcontact::program
