// A cut as its pictures and its replay.
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
  std::string name;  // of the pictures' files: NAME_force, NAME_cut
  const CutScene& scene;
  const CuttingRun& run;
  const Cloud& after;
  ForceChartWords force;
  CutPictureWords cut;
  std::string body, tool;  // what they are called in the replay
};

// Hands the stage the two pictures and a replay of two takes, the tool over the whole body and in
// what it has left of it; each only where the stage wants it.
void showCut(DemoStage& stage, const ShownCut& shown);

// What every cut must hold to: Archard's volume, passivity, no jumps.
std::vector<ReplayCheck> stepChecks(const CuttingRun& run, const CuttingFigures& figures);

}  // namespace cloudcontact::program
