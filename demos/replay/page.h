// A replay as one file that a browser shows without a network: three.js around the glTF, with
// contacts, figures over time and voxels beside it.
#pragma once

#include <string>

#include "replay/replay.h"

namespace cloudcontact::program {

std::string pageBytes(const Replay& replay);

// How a page carries bytes: deflated by zlib (RFC 1950), which a browser's
// DecompressionStream("deflate") reads, and spelled in base64 (RFC 4648, padded).
std::string deflated(const std::string& bytes);
std::string base64(const std::string& bytes);

}  // namespace cloudcontact::program
