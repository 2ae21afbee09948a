// The pictures, the replay and the checks of a cutting demo.
#pragma once

#include <string>
#include <vector>

#include "demos/cut_scenes.h"
#include "demos/demo.h"
#include "draw/cut_picture.h"
#include "draw/force_chart.h"
#include "scene/cutting_figures.h"

namespace cloudcontact::program {

struct ShownCut {
  std::string name;  // of the picture files: NAME_force, NAME_cut
  const CutScene& scene;
  const CuttingRun& run;
  const Cloud& after;
  ForceChartText force;
  CutPictureText cut;
  std::string body, tool;  // names in the replay
};

// Adds to the stage, if it wants them, the two pictures and a replay of two takes: the tool with
// the whole body, and with the remaining one.
void showCut(DemoStage& stage, const ShownCut& shown);

// Checks of every cut: Archard's volume, passivity, no jumps of the force.
std::vector<ReplayCheck> stepChecks(const CuttingRun& run, const CuttingFigures& figures);

}  // namespace cloudcontact::program
