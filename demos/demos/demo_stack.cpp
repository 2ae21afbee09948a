// The demo `stack`: ten boxes, a minute, coarse steps, no sleeping.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "demos/demo.h"

namespace cloudcontact::program {
namespace stack {

constexpr int kBoxes = 10;
constexpr double kEdge = 2;     // as in Bullet's own examples [m]
constexpr double kMass = 1000;  // [kg]
constexpr double kVoxel = 0.1;  // [m]
constexpr double kSeconds = 60;
// The stiffness has a lower and an upper bound. A stack of n boxes on springs is a column under its
// own weight, with joints of stiffness k edge^2 / 12 against tilting. It buckles (Greenhill 1881)
// below k = 1.53 m g n^3 / edge: 7.5e6 N/m here. Above 20 times m/2 / step^2, 3.6e7 N/m, ten
// iterations of the solver at 60 Hz no longer propagate the weight through ten boxes.
constexpr double kStiffness = 1.8e7;  // [N/m] of a pair
constexpr double kDamping = 1.9e5;    // [N s/m] of a pair: ratio 1

SceneDescription scene(bool stated, double step) {
  SceneDescription scene;
  scene.name = "stack";
  scene.step = step;
  scene.bodies.push_back(demoFloor(0.6));
  for (int i = 0; i < kBoxes; ++i) {
    SceneBody box;
    box.name = "box" + std::to_string(i);
    box.model = i + 1;
    box.pose.position = Vec3(0, 0, (i + 0.5) * kEdge);
    box.mass = kMass;
    box.friction = 0.6;
    // The springs of two bodies act in series: each has twice the pair's stiffness.
    if (stated) box.stiffness = 2 * kStiffness, box.damping = 2 * kDamping;
    box.collisions.push_back({"box", Pose(), SceneBox{Vec3::Constant(kEdge)}});
    scene.bodies.push_back(box);
  }
  return scene;
}

struct Outcome {
  double moved = 0;   // largest sideways motion [voxels]
  double sunk = 0;    // largest downward motion [voxels]
  double tilted = 0;  // [deg]
  bool stands() const { return moved < 1 && sunk < 1 && tilted < 1; }
};

Outcome run(DemoStage& stage, Method method, bool stated, double step, const std::string& label) {
  const SceneDescription description = scene(stated, step);
  SimulationSettings settings;
  settings.seconds = kSeconds;
  settings.step = step;
  settings.instants = 1;
  const SimulationReport report =
      stage.run(description, demoSettings(kVoxel, method), settings, label);
  Outcome worst;
  for (std::size_t i = 1; i < report.bodies.size(); ++i) {
    const Vec3 off = report.bodies[i].pose.position - description.bodies[i].pose.position;
    const Eigen::AngleAxisd turn(report.bodies[i].pose.orientation);
    worst.moved = std::max(worst.moved, off.head<2>().norm() / kVoxel);
    worst.sunk = std::max(worst.sunk, std::abs(off.z()) / kVoxel);
    worst.tilted = std::max(worst.tilted, std::abs(turn.angle()) * 180 / std::numbers::pi);
  }
  return worst;
}

std::string outcomeText(const Outcome& o) {
  return std::string(o.stands() ? "stood" : "fell") + ", moved " + figure(o.moved, 4, "vox") +
         ", sank " + figure(o.sunk, 3, "vox") + ", tilted " + figure(o.tilted, 3, "deg");
}

}  // namespace stack

std::vector<ReplayCheck> runStack(DemoStage& stage) {
  using namespace stack;
  std::vector<ReplayCheck> checks;
  for (const bool stated : {true, false})
    for (const int rate : {240, 60}) {
      const std::string label =
          std::to_string(rate) + " Hz, " + (stated ? "given stiffness" : "automatic stiffness");
      const Outcome outcome = run(stage, Method::Cloud, stated, 1.0 / rate, label);
      checks.push_back({"clouds stand for 60 s at " + std::to_string(rate) + " Hz with " +
                            (stated ? "a given" : "an automatic") + " stiffness",
                        outcomeText(outcome), outcome.stands()});
    }
  // Reported only: it is not an outcome of this project.
  checks.push_back(
      {"for comparison, Bullet's own boxes fall at 60 Hz",
       outcomeText(run(stage, Method::Primitive, false, 1.0 / 60, "Bullet's own boxes, 60 Hz")),
       true});
  return checks;
}

}  // namespace cloudcontact::program
