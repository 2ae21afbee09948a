// Which body has which colour in a replay: what stands still is grey, what moves is coloured.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "replay/replay.h"

namespace cloudcontact::program {

struct BodyColor {
  std::string name;              // "#rrggbb"
  std::array<double, 3> linear;  // as glTF wants it: without the screen's gamma, 0..1
};

// One a body.
std::vector<BodyColor> bodyColors(const std::vector<ReplayBody>& bodies);

}  // namespace cloudcontact::program
