// Makes takes without a Bullet world: the tool's motion as keys, the force as one contact.
#include "demos/cut_presentation.h"

#include <cloudcontact/field/surface_field.h>

#include <algorithm>
#include <cmath>

#include "io/text.h"
#include "scene/level_surface.h"

namespace cloudcontact::program {

namespace {

constexpr double kMostStep = 0.05,
                 kMostCuttingStep = 0.15;  // allowed changes of the force in a tick
constexpr double kArchard = 0.03;          // allowed error of the volume
constexpr double kLeastEnergy = -1e-6;     // [J]
constexpr double kFramesASecond = 60;
constexpr double kTolerance = 1e-4;  // of the tool's motion, relative to the body's size
constexpr int kMostMeshed = 110;     // blocks along the longest axis of the body's mesh

Eigen::AlignedBox3d boxOf(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& v : mesh.vertices) box.extend(v);
  return box;
}

ReplayBody bodyOf(const std::string& name, const Cloud& cloud) {
  ReplayBody body;
  body.name = name;
  body.isStatic = true;
  const int step = (cloud.size().maxCoeff() + kMostMeshed - 1) / kMostMeshed;
  body.drawn.parts.push_back({std::make_shared<const Mesh>(cloudSurface(cloud, step)), Pose(), {}});
  FieldSettings settings;
  body.drawn.clouds.push_back({SurfaceField::build(cloud, settings), Pose()});
  body.keys = {{0, Pose()}};
  return body;
}

ReplayBody toolOf(const ShownCut& shown, double size) {
  ReplayBody body;
  body.name = shown.tool;
  body.mass = shown.scene.task.hand.mass;
  body.drawn.parts.push_back({std::make_shared<const Mesh>(shown.scene.tool), Pose(), {}});
  Keyframes keys(boxOf(shown.scene.tool).sizes().maxCoeff(), kTolerance * size);
  for (const CuttingTick& t : shown.run.ticks)
    keys.add(t.time, {shown.scene.task.orientation, t.tool});
  keys.finish();
  body.keys = keys.keys();
  return body;
}

void addFrames(ReplayTake& take, const ShownCut& shown, double size) {
  take.contacts = ReplayContacts(kTolerance * size);
  const auto every =
      static_cast<std::size_t>(std::max(1.0, std::round(1 / (kFramesASecond * shown.run.step))));
  ContactsNow now;
  for (std::size_t k = 0; k < shown.run.ticks.size(); k += every) {
    const CuttingTick& t = shown.run.ticks[k];
    now.patches.clear();
    now.points.clear();
    if (t.depth > 0) {
      now.patches.push_back({0, 1, 0, 1});
      now.points.push_back({t.center, t.force.stableNormalized(), t.force, t.depth});
    }
    take.contacts.add(now, {true, false});
    // These bodies have no gravity and no springs, so their energies are zero.
    take.frames.push_back({t.time, 0, 0, 0, t.depth, 1e-6 * static_cast<double>(t.microseconds)});
  }
}

ReplayTake takeOf(const ShownCut& shown, const Cloud& cloud, const std::string& label) {
  ReplayTake take;
  take.label = label;
  take.bodies.push_back(bodyOf(shown.body, cloud));
  take.start = boxOf(*take.bodies[0].drawn.parts[0].mesh);
  const double size = take.start.diagonal().norm();
  take.bodies.push_back(toolOf(shown, size));
  take.extent = take.start;
  for (const CuttingTick& t : shown.run.ticks) take.extent.extend(t.tool);
  addFrames(take, shown, size);
  return take;
}

}  // namespace

void showCut(DemoStage& stage, const ShownCut& shown) {
  if (stage.wantsPictures()) {
    stage.addPicture(shown.name + "_force",
                     std::make_shared<const Drawing>(forceChart(shown.run, shown.force)));
    stage.addPicture(shown.name + "_cut", std::make_shared<const Drawing>(cutPicture(
                                              shown.scene.cloud, shown.after, shown.cut)));
  }
  if (!stage.wantsReplay()) return;
  ReplayTake first = takeOf(shown, shown.scene.cloud, "the whole " + shown.body);
  ReplayTake second = takeOf(shown, shown.after, "the cut " + shown.body);
  second.offset.x() = 1.2 * first.extent.sizes().x();
  const double voxel = shown.scene.cloud.voxelSize();
  stage.addTakes({std::move(first), std::move(second)}, shown.run.ticks.back().time,
                 "voxels of " + lengthText(voxel) + ", a haptic loop at 1 kHz", voxel);
}

std::vector<ReplayCheck> stepChecks(const CuttingRun& run, const CuttingFigures& f) {
  return {
      {"the removed volume follows Archard's law within 3 %",
       figure(1e9 * f.cutVolume, 2) + " and " + figure(1e9 * f.workVolume, 2, "mm^3"),
       std::abs(f.cutVolume - f.workVolume) <= kArchard * f.workVolume && f.workVolume > 0},
      {"the hand never gets back more energy than it gave", figure(1e6 * run.leastEnergy, 3, "uJ"),
       run.leastEnergy >= kLeastEnergy},
      {"no tick changes the force by over 5 %, or by over 15 % while cutting",
       figure(100 * f.largestStep, 1, "%") + " and " + figure(100 * f.largestCuttingStep, 1, "%"),
       f.largestStep <= kMostStep && f.largestCuttingStep <= kMostCuttingStep}};
}

}  // namespace cloudcontact::program
