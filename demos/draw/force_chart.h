// The chart of a cutting run: the force and the touched tissues, the depth of the tool, and the
// removed volume next to Archard's law, over time.
#pragma once

#include <string>

#include "draw/drawing.h"
#include "scene/cutting_run.h"

namespace cloudcontact::program {

struct ForceChartText {
  std::string title, below;
  Vec3 inward = -Vec3::UnitZ();  // unit direction in which the tool's depth is measured
  std::string way;               // label of that depth with its unit: "Depth of the bur [mm]"
};

// Time starts with the run, depth at the first contact. Throws std::invalid_argument if the run has
// no ticks.
Drawing forceChart(const CuttingRun& run, const ForceChartText& words);

}  // namespace cloudcontact::program
