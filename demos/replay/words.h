// What a replay says of the run it shows.
#pragma once

#include "replay/replay.h"
#include "scene/simulation.h"

namespace cloudcontact::program {

// "clouds of 0.25 mm voxels, steps of 1 ms"
std::string setupText(const WorldSettings& settings, double step, int substeps = 1);

// Names and figures of how it went.
std::vector<std::pair<std::string, std::string>> factsOf(const SimulationReport& report);

}  // namespace cloudcontact::program
