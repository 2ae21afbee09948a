// What a cache of the library's results depends on, beside their input.
#pragma once

#include <string_view>

namespace cloudcontact {

// A hash of the sources of meshes, clouds and fields, as hexadecimal digits: libraries of equal
// hashes make equal clouds and fields.
std::string_view sourceHash();

}  // namespace cloudcontact
