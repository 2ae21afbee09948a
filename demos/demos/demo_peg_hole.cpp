// The demo `peg_hole`: a peg enters a tight hole without jamming.
#include <cmath>
#include <numbers>

#include "demos/demo.h"
#include "scene/generated_mesh.h"

namespace cloudcontact::program {
namespace peg_hole {

constexpr double kVoxel = 0.1e-3;  // [m]
constexpr double kStep = 1.0 / 480;
constexpr double kPegRadius = 4e-3, kHoleRadius = 4.05e-3, kChamfer = 0.5e-3;
constexpr double kHeight = 12e-3;  // of the block
constexpr double kStart = 8e-3;    // of the peg's end above the floor
constexpr double kFriction = 0.1;
// The peg sags by 0.04 voxel. With ten times this stiffness it would rest on the noise of the fits
// (0.004 voxel) and rock on its rim.
constexpr double kStiffness = 2e4, kDamping = 12;

SceneDescription scene() {
  const DemoMatter fixed{0, kFriction, kStiffness, kDamping},
      steel{0.0079, kFriction, kStiffness, kDamping};
  // Offset and tilt within the clearance at this depth.
  const Pose start{Eigen::Quaterniond(Eigen::AngleAxisd(0.002, Vec3(1, -0.5, 0).normalized())),
                   Vec3(2e-5, -1e-5, kStart)};
  SceneDescription scene;
  scene.name = "peg_hole";
  scene.step = kStep;
  scene.bodies = {
      demoFloor(kFriction),
      demoBody("hole", "hole",
               std::make_shared<Mesh>(holeMesh(kHoleRadius, 14e-3, kHeight, kChamfer)), Pose(),
               fixed),
      demoBody("peg", "peg", std::make_shared<Mesh>(pegMesh(kPegRadius, 20e-3, kChamfer)), start,
               steel)};
  for (int i = 0; i < 3; ++i) scene.bodies[i].model = i;
  return scene;
}

}  // namespace peg_hole

std::vector<ReplayCheck> runPegHole(DemoStage& stage) {
  using namespace peg_hole;
  SimulationSettings settings;
  settings.seconds = 1;
  settings.step = kStep;
  settings.instants = 20;
  const SimulationReport report = stage.run(scene(), demoSettings(kVoxel), settings, "");
  const BodyState& peg = report.bodies[2];
  const double height = peg.pose.position.z();
  const Vec3 axis = peg.pose.orientation * Vec3::UnitZ();
  const double tilt = std::acos(std::min(1.0, axis.z())) * 180 / std::numbers::pi;
  return {{"the peg's end reaches the floor", figure(1e3 * height, 3, "mm above it"),
           std::abs(height) < 0.05e-3},
          {"it is upright within the hole's 0.5 deg", figure(tilt, 3, "deg"), tilt < 0.5},
          {"it lies still", figure(1e3 * peg.linearVelocity.norm(), 3, "mm/s"),
           peg.linearVelocity.norm() < 1e-3},
          {"it never overlaps by over half the clearance",
           figure(1e3 * report.maxPenetration, 4, "mm"), report.maxPenetration < 0.025e-3}};
}

}  // namespace cloudcontact::program
