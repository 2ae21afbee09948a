// What a page knows beyond the glTF: words, figures over time, contacts, voxels.
#pragma once

#include <string>

#include "replay/replay.h"

namespace cloudcontact::program {

// "RPLY", the length of a JSON text as 4 bytes (little endian), that text, padded with blanks so
// that 8 divides what is before the arrays, and the arrays. The JSON refers to an array as {"at":
// byte behind the text, "length": numbers, "type": "u8" | "i8" | "u16" | "i16" | "u32" | "f32"}.
// Places are whole numbers of 1/8191 of the diagonal of the take's box of contacts, directions of
// 1/127, depths of 1/1023 of the largest there is, and so are forces by their square root: the
// small ones keep their digits.
std::string pageRecord(const Replay& replay);

}  // namespace cloudcontact::program
