// The data of a page beside the glTF: texts, figures over time, contacts, voxels.
#pragma once

#include <string>

#include "replay/replay.h"

namespace cloudcontact::program {

// Format: "RPLY", the length of a JSON text as 4 bytes (little endian), that text, padded with
// blanks to a multiple of 8 bytes, and the arrays. The JSON refers to an array as {"at": byte after
// the text, "length": numbers, "type": "u8" | "i8" | "u16" | "i16" | "u32" | "f32"}. Positions are
// integers in units of 1/8191 of the diagonal of the take's contacts, directions in 1/127, depths
// in 1/1023 of the largest depth. Forces are stored as square roots in 1/1023 of the largest, which
// keeps the digits of small ones.
std::string pageRecord(const Replay& replay);

}  // namespace cloudcontact::program
