// The demo `scalpel`: a blade slits skin and the muscle below it.
#include <algorithm>
#include <cmath>

#include "demos/cut_presentation.h"
#include "demos/cut_scenes.h"
#include "demos/demo.h"
#include "io/progress.h"
#include "scene/cutting_figures.h"

namespace cloudcontact::program {

namespace scalpel {

// Depth of the slit at a point of the line, and its width at the surface [m].
struct Slit {
  double depth = 0, width = 0;
};

Slit slitAt(const Cloud& before, const Cloud& after, double x) {
  const double h = after.voxelSize();
  const auto index = [&](double place, int axis) {
    return static_cast<int>(std::floor((place - after.origin()[axis]) / h));
  };
  const int at = index(x, 0), top = index(kSlabTop - h / 2, 2);
  Slit slit;
  for (int z = top; z >= 0; --z)
    slit.depth += h * (255 - after.coverage(at, index(0, 1), z)) / 255.0 *
                  (before.coverage(at, index(0, 1), z) > 0);
  for (int y = 0; y < after.size().y(); ++y)
    slit.width += h * (before.coverage(at, y, top) - after.coverage(at, y, top)) / 255.0;
  return slit;
}

}  // namespace scalpel

std::vector<ReplayCheck> runScalpel(DemoStage& stage) {
  using namespace scalpel;
  CutScene scene = scalpelScene();
  BaseVectorField field(scene.cloud, scene.tissues, sphereWindow(scene.cloud.voxelSize()));
  scene.task.progress = progressBar("cutting");
  const CuttingRun run = runCutting(field, scene.task);
  const CuttingFigures f = figuresOf(run);
  const Cloud after = field.cloud();
  double least = 1, most = 0, widest = 0;
  for (double x = kCutStart + 2e-3; x <= kCutEnd - 2e-3; x += after.voxelSize()) {
    const Slit slit = slitAt(scene.cloud, after, x);
    least = std::min(least, slit.depth), most = std::max(most, slit.depth);
    widest = std::max(widest, slit.width);
  }
  const double blade = 2 * kBladeHalfThickness, voxel = after.voxelSize();
  std::vector<ReplayCheck> checks = {
      {"the skin is cut along the whole line", figure(1e3 * least, 2, "mm deep at least"),
       least > kSkinThickness},
      {"the slit is no deeper than the hand's plan", figure(1e3 * most, 2, "mm of 5"),
       most <= kBladePlan},
      {"the slit is no wider than the blade, 0.8 mm, and a voxel", figure(1e3 * widest, 2, "mm"),
       widest > 0.5 * blade && widest <= blade + voxel}};
  for (const ReplayCheck& check : stepChecks(run, f)) checks.push_back(check);
  const std::string below = "A blade 0.8 mm thick, drawn at 8 mm/s through 2 mm of skin; " +
                            figure(run.ticks.back().time, 1) + " s at 1 kHz, " +
                            figure(1e9 * f.cutVolume, 1, "mm\u00b3 removed");
  showCut(stage, {"scalpel",
                  scene,
                  run,
                  after,
                  {"Force on the hand while a blade slits skin", below, -Vec3::UnitZ(),
                   "Depth of the blade below its first touch [mm]"},
                  {"The slit of the blade", below, {}, false},
                  "slab",
                  "blade"});
  return checks;
}

}  // namespace cloudcontact::program
