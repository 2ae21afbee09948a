// The demo `drill`: a bur opens a molar. Checks the force on the hand and the removed volume
// against physics.
#include <algorithm>
#include <cmath>

#include "demos/cut_presentation.h"
#include "demos/cut_scenes.h"
#include "demos/demo.h"
#include "io/progress.h"
#include "scene/cutting_figures.h"

namespace cloudcontact::program {

namespace drill {

std::size_t indexOf(const std::vector<std::string>& names, const char* name) {
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

// The lowest point that lost at least half of its material [m].
double floorOf(const Cloud& before, const Cloud& after) {
  double lowest = 1;
  const Eigen::Vector3i size = before.size();
  for (int z = size.z() - 1; z >= 0; --z)
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x)
        if (before.coverage(x, y, z) - after.coverage(x, y, z) > 127)
          lowest = std::min(lowest, before.center(x, y, z).z() - before.voxelSize() / 2);
  return lowest;
}

ReplayCheck orderOf(const CuttingFigures& f, const std::vector<std::string>& names) {
  const auto touch = [&](const char* name) { return f.tissues[indexOf(names, name)].firstTouch; };
  const auto enamel = touch("enamel"), caries = touch("caries"), dentin = touch("dentin");
  const bool all = enamel && caries && dentin;
  return {"it meets enamel first, then caries, then dentin",
          all ? figure(*enamel, 2) + ", " + figure(*caries, 2) + ", " + figure(*dentin, 2, "s")
              : "not all of them",
          all && *enamel < *caries && *caries <= *dentin};
}

}  // namespace drill

std::vector<ReplayCheck> runDrill(DemoStage& stage) {
  using namespace drill;
  CutScene scene = drillScene();
  BaseVectorField field(scene.cloud, scene.tissues, sphereWindow(scene.cloud.voxelSize()));
  scene.task.progress = progressBar("drilling");
  const CuttingRun run = runCutting(field, scene.task);
  const CuttingFigures f = figuresOf(run);
  const Cloud after = field.cloud();
  const std::size_t pulp = indexOf(run.tissues, "pulp");
  const TissueFigures& enamel = f.tissues[indexOf(run.tissues, "enamel")];
  const TissueFigures& caries = f.tissues[indexOf(run.tissues, "caries")];
  const double opened = materialVolumes(scene.cloud)[pulp] - materialVolumes(after)[pulp];
  const double floor = floorOf(scene.cloud, after);
  std::vector<ReplayCheck> checks = {
      orderOf(f, run.tissues),
      {"the force in caries is less than half of that in enamel",
       figure(caries.meanForce, 2) + " and " + figure(enamel.meanForce, 2, "N"),
       caries.seconds > 0 && caries.meanForce < 0.5 * enamel.meanForce},
      {"the cavity's floor is 1.35 mm above the crown's base, within 0.15",
       figure(1e3 * floor, 2, "mm"), std::abs(floor - kDrillFloor) < 0.15e-3},
      {"the pulp stays whole", figure(1e9 * opened, 3, "mm^3 removed"), opened == 0}};
  for (const ReplayCheck& check : stepChecks(run, f)) checks.push_back(check);
  const std::string below = "A ball bur of 1.2 mm at 300,000 rpm; " +
                            figure(run.ticks.back().time, 1) + " s at 1 kHz, " +
                            figure(1e9 * f.cutVolume, 1, "mm\u00b3 removed");
  showCut(stage, {"drill",
                  scene,
                  run,
                  after,
                  {"Force on the hand while a bur opens a tooth", below, -Vec3::UnitZ(),
                   "Depth of the bur below its first touch [mm]"},
                  {"The tooth opened by the bur", below, {}, true},
                  "tooth",
                  "bur"});
  return checks;
}

}  // namespace cloudcontact::program
