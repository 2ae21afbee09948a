// A replay as one file that a browser shows without a network: three.js around the glTF, with
// contacts, figures over time and voxels beside it.
#pragma once

#include <string>

#include "replay/replay.h"

namespace cloudcontact::program {

std::string pageBytes(const Replay& replay);

}  // namespace cloudcontact::program
