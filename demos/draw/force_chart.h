// The chart of a cut: force over time with what the tool touches, its way into the work, and the
// volume that went beside what Archard's law says.
#pragma once

#include <string>

#include "draw/drawing.h"
#include "scene/cutting_run.h"

namespace cloudcontact::program {

struct ForceChartWords {
  std::string title, below;
  Vec3 inward = -Vec3::UnitZ();  // unit: the direction in which the tool's way is counted
  std::string way;               // name of that way with its unit: "Depth of the bur [mm]"
};

// Times begin at the run's start; the way at the first touch. Throws std::invalid_argument where
// the run has no ticks.
Drawing forceChart(const CuttingRun& run, const ForceChartWords& words);

}  // namespace cloudcontact::program
