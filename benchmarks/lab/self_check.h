// The laboratory's own check of this project: what our method must keep, whatever the peers do.
#pragma once

#include <string>
#include <vector>

#include "lab/chart.h"
#include "lab/stability.h"

namespace cloudcontact::program::lab {

// What our rows miss, a line each; none where all is well. On smooth cases at voxel = size / 32:
// normals 0.3 deg in the mean and 1 deg for 95 of 100, force within 1 %, torque within 5 %. No
// trial of ours may fail a rule.
std::vector<std::string> ownFaults(const std::vector<ChartRow>& chart,
                                   const std::vector<StabilityRow>& stability);

}  // namespace cloudcontact::program::lab
