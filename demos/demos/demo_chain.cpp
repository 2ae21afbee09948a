// The demo `chain`: ten links that hold each other by their shape.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "demos/demo.h"
#include "scene/generated_mesh.h"

namespace cloudcontact::program {
namespace chain {

constexpr int kLinks = 10;
constexpr double kVoxel = 0.02;  // [m]
constexpr double kStep = 1.0 / 240;
constexpr double kSeconds = 10;
constexpr double kMass = 40;
constexpr double kStiffness = 1e6;  // of a pair: the first joint carries 3.5 kN and sags 3.5 mm

// Distance of neighbors under load, whose wires touch where they cross.
double pitch(const ChainLink& link) {
  return link.straight + 2 * link.bend - 2 * link.wire;
}

// Sag of the joint above a link under the weight of it and all below [m].
double sag(int link) {
  return (kLinks - link) * kMass * 9.8 / kStiffness;
}

SceneDescription scene(const ChainLink& link) {
  const auto mesh = std::make_shared<Mesh>(chainLinkMesh(link));
  SceneDescription scene;
  scene.name = "chain";
  scene.step = kStep;
  // The link's long axis, y, is vertical; every other link is turned by 90 degrees about it.
  const Eigen::Quaterniond up(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitX()));
  const Eigen::Quaterniond quarter(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitZ()));
  // It starts in equilibrium: nothing would damp the swing and spin after a drop.
  double height = 12;
  for (int i = 0; i < kLinks; ++i) {
    if (i > 0) height -= pitch(link) + sag(i);
    const Pose pose{i % 2 ? quarter * up : up, Vec3(0, 0, height)};
    const DemoMatter iron{i == 0 ? 0 : kMass, 0.4, 2 * kStiffness, 4e4};
    scene.bodies.push_back(demoBody("link" + std::to_string(i), "link", mesh, pose, iron));
    scene.bodies.back().model = i;
  }
  return scene;
}

}  // namespace chain

std::vector<ReplayCheck> runChain(DemoStage& stage) {
  using namespace chain;
  const ChainLink link{0.1, 0.25, 0.6, 48, 64};
  SimulationSettings settings;
  settings.seconds = kSeconds;
  settings.step = kStep;
  settings.instants = 10;
  const SimulationReport report = stage.run(scene(link), demoSettings(kVoxel), settings, "");
  double speed = 0, sideways = 0, gap = 0;
  for (int i = 1; i < kLinks; ++i) {
    const BodyState &above = report.bodies[i - 1], &here = report.bodies[i];
    speed = std::max({speed, here.linearVelocity.norm(), here.angularVelocity.norm()});
    sideways = std::max(sideways, here.pose.position.head<2>().norm());
    const double distance = above.pose.position.z() - here.pose.position.z();
    gap = std::max(gap, std::abs(distance - pitch(link) - sag(i)));
  }
  return {{"all links hang still, under 1 mm/s and 1 mrad/s",
           figure(1e3 * speed, 4, "mm/s or mrad/s at most"), speed < 1e-3},
          {"straight down within half a voxel", figure(sideways / kVoxel, 4, "vox sideways"),
           sideways < 0.5 * kVoxel},
          {"neighbors at a pitch and m g / k within half a voxel",
           figure(gap / kVoxel, 3, "vox off"), gap < 0.5 * kVoxel}};
}

}  // namespace cloudcontact::program
