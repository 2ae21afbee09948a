// Checks CloudContact's results against the project's aims, whatever the peers do.
#pragma once

#include <string>
#include <vector>

#include "lab/chart_row.h"
#include "lab/stability.h"

namespace cloudcontact::program::lab {

// One line per aim that is missed. On smooth cases at voxel = size / 32: normals within 0.3 deg in
// the mean and 1 deg for 95 of 100, force within 1 %, torque within 5 %. In stability trials: all
// rules hold.
std::vector<std::string> ownFaults(const std::vector<ChartRow>& chart,
                                   const std::vector<StabilityRow>& stability);

}  // namespace cloudcontact::program::lab
