// The colors of bodies in a replay: gray for static bodies, a palette for moving ones.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "replay/replay.h"

namespace cloudcontact::program {

struct BodyColor {
  std::string name;              // "#rrggbb"
  std::array<double, 3> linear;  // linear RGB as in glTF, 0..1
};

// One for each body.
std::vector<BodyColor> bodyColors(const std::vector<ReplayBody>& bodies);

}  // namespace cloudcontact::program
