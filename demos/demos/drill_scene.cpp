// The drill: a tungsten carbide ball bur of 1.2 mm at 300,000 rpm, in a hand whose wrist is as
// stiff as the device's rendering.
#include <cloudcontact/field/window.h>

#include <numbers>

#include "demos/cut_scenes.h"
#include "scene/primitive_mesh.h"
#include "scene/tooth.h"

namespace cloudcontact::program {

namespace drill {

constexpr double kMm = 1e-3;
constexpr double kVoxel = 0.1 * kMm;
constexpr double kBur = 0.6 * kMm;            // radius
constexpr double kSpindle = 300000 / 60.0;    // [1/s]
constexpr double kDeep = kDrillFloor + kBur;  // the bur's center at its deepest
constexpr double kSide = 1.2 * kMm;           // from the pit to the borehole, along the fissure
constexpr double kWide = 0.15 * kMm;          // margin of the cavity around the bur

// A tenth of the plowed volume comes off. The bur then passes enamel at 1 mm/s with one newton,
// and the whole demo takes 20 s.
constexpr double kEfficiency = 0.1;

// Straight down and slowly up: a bur rubs on its own hole on the way out, with a force that grows
// with its speed.
void addBorehole(std::vector<PathPoint>& path) {
  path.push_back({Vec3(kSide, 0, 6.4 * kMm), 1, 0});
  path.push_back({Vec3(kSide, 0, 5.8 * kMm), 3 * kMm, 0});
  path.push_back({Vec3(kSide, 0, kDeep), 0.9 * kMm, 0.6});
  path.push_back({Vec3(kSide, 0, 4.7 * kMm), 1 * kMm, 0});
}

// Layer by layer, there and back, with a pause at each end because the hand lags behind its plan.
void addCavity(std::vector<PathPoint>& path) {
  for (const double z : {4.7 * kMm, 3.8 * kMm, 2.9 * kMm, kDeep}) {
    path.push_back({Vec3(kSide, kWide, z), 1.5 * kMm, 0});
    path.push_back({Vec3(-kSide, kWide, z), 2 * kMm, 0.15});
    path.push_back({Vec3(-kSide, -kWide, z), 2 * kMm, 0});
    path.push_back({Vec3(kSide, -kWide, z), 2.5 * kMm, 0.1});
  }
  path.push_back({Vec3(kSide, 0, kDeep), 2 * kMm, 0.1});
  path.push_back({Vec3(kSide, 0, 4.7 * kMm), 1.2 * kMm, 0});
  path.push_back({Vec3(kSide, 0, 6.4 * kMm), 5 * kMm, 0});
}

}  // namespace drill

CutScene drillScene(int threads) {
  using namespace drill;
  std::vector<PathPoint> path;
  addBorehole(path);
  addCavity(path);
  CutScene scene{toothCloud(kVoxel, threads), {}, {{}, {}, PlannedPath(path), {}, {}}, {}};
  scene.tissues = tissuesOf(dentalTissues(), scene.cloud.materials());
  HapticSettings& haptic = scene.task.haptic;
  haptic.tool.area = {Sphere{kBur}};
  haptic.handStiffness = 5000;
  haptic.handDamping = 2.5;
  haptic.cutter = Cutter{17e9, kEfficiency, 2 * std::numbers::pi * kSpindle * kBur};
  scene.task.orientation = Eigen::Quaterniond::Identity();
  scene.task.hand = {0.1, 5000, 20, 0, 10};
  scene.tool = primitiveMesh(Sphere{kBur}, 0.02 * kBur);
  return scene;
}

}  // namespace cloudcontact::program
