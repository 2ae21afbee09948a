// How a page carries bytes: squeezed by zlib's deflate, spelled in base64.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cloudcontact::program {

// zlib's format (RFC 1950), which browsers' DecompressionStream("deflate") reads.
std::string deflated(const std::string& bytes);
std::string base64(const std::string& bytes);  // RFC 4648, padded

}  // namespace cloudcontact::program
