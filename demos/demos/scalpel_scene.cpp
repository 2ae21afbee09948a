// The scalpel: a round-bellied blade, 0.8 mm thick, drawn through 2 mm of skin and as much muscle.
// Soft tissue is described by its toughness, the work per area of a cut: 2,800 J/m^2 for chicken
// skin cut with scissors, 550 and more for porcine muscle (both from "Recent Advances in Soft
// Biological Tissue Manipulating Technologies", Chin. J. Mech. Eng. 35, 2022, table 2). The blade
// removes a strip of its own width, so toughness over that width is the work per volume: Archard's
// hardness over efficiency. Stiffness and damping are chosen for the feel of a hand; real skin is
// no linear spring.
#include <cloudcontact/voxels/digitize.h>

#include "demos/cut_scenes.h"
#include "scene/primitive_mesh.h"

namespace cloudcontact::program {

namespace scalpel {

constexpr double kMm = 1e-3;
constexpr double kVoxel = 0.2 * kMm;
constexpr double kSkinToughness = 2800, kMuscleToughness = 550;  // [J/m^2]
constexpr double kSlab = 8 * kMm;                                // thickness
constexpr double kLength = 36 * kMm, kWidth = 10 * kMm;
constexpr double kBelly = 5 * kMm;  // half length and half height of the blade
// Width of the cutting rim. With 0.7 mm half of the skin in the slit remains: tissue yields before
// it is cut, and nothing cuts it behind the rim.
constexpr double kEdge = 3 * kMm;

NamedMesh box(const char* name, double top) {
  const double height = kSlab + top;  // both start at z = -kSlab
  NamedMesh part{name, primitiveMesh(Box{Vec3(kLength, kWidth, height) / 2}, kVoxel)};
  for (Vec3& v : part.mesh.vertices) v.z() += top - height / 2;
  return part;
}

Cloud slab(int threads) {
  DigitizeSettings settings;
  settings.voxelSize = kVoxel;
  settings.threads = threads;
  return digitize({box("skin", kSlabTop), box("muscle", kSlabTop - kSkinThickness)}, settings);
}

// The blade, and its part that does not cut: all but the rim.
Detection blade() {
  Detection tool;
  tool.area = {Ellipsoid{Vec3(kBelly, kBladeHalfThickness, kBelly)}};
  tool.hardness = false;
  tool.parts = {
      {PlacedSolid{Ellipsoid{Vec3(kBelly - kEdge, 5 * kBladeHalfThickness, kBelly - kEdge)}}, 0.0}};
  return tool;
}

}  // namespace scalpel

CutScene scalpelScene(int threads) {
  using namespace scalpel;
  const double above = kBelly + 1 * kMm, deep = kBelly - kBladePlan;
  const PlannedPath path({{Vec3(kCutStart - 8 * kMm, 0, above), 1, 0},
                          {Vec3(kCutStart - 6 * kMm, 0, kBelly), 5 * kMm, 0},
                          {Vec3(kCutStart, 0, deep), 6 * kMm, 0},
                          {Vec3(kCutEnd, 0, deep), 8 * kMm, 0.1},
                          {Vec3(kCutEnd - 2 * kMm, 0, above), 5 * kMm, 0}});
  CutScene scene{slab(threads), {}, {{}, {}, path, {}, {}}, {}};
  const auto tissue = [](const char* name, double k, double toughness, double density) {
    return Tissue{name, k, 1e-4 * k, toughness / (2 * kBladeHalfThickness), density};
  };
  scene.tissues = tissuesOf(
      {tissue("skin", 4e4, kSkinToughness, 1100), tissue("muscle", 1.6e4, kMuscleToughness, 1060)},
      scene.cloud.materials());
  HapticSettings& haptic = scene.task.haptic;
  haptic.tool = blade();
  haptic.handStiffness = 10000;
  haptic.handDamping = 5;
  haptic.mostForce = 30;
  haptic.cutter = Cutter{1e9, 1.0, 0.0};
  scene.task.orientation = Eigen::Quaterniond::Identity();
  scene.task.hand = {0.2, 20000, 80, 0, 10};
  Mesh ball = primitiveMesh(Sphere{1}, 0.02);
  scene.tool = ball.scaled(Vec3(kBelly, kBladeHalfThickness, kBelly));
  return scene;
}

}  // namespace cloudcontact::program
