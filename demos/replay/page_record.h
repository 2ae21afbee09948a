// The data of a page beside the glTF: texts, figures over time, contacts, voxels.
#pragma once

#include <string>

#include "replay/replay.h"

namespace cloudcontact::program {

// As PackedArrays; contacts as contactsJson().
std::string pageRecord(const Replay& replay);

}  // namespace cloudcontact::program
