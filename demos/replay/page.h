// A replay as a single HTML file that needs no network: the glTF in three.js, with contacts, graphs
// and voxels.
#pragma once

#include <string>

#include "replay/replay.h"

namespace cloudcontact::program {

std::string pageBytes(const Replay& replay);

// The encoding of bytes in a page: zlib (RFC 1950), which a browser's
// DecompressionStream("deflate") reads, then base64 (RFC 4648, padded).
std::string deflated(const std::string& bytes);
std::string base64(const std::string& bytes);

}  // namespace cloudcontact::program
