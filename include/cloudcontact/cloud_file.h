// Clouds kept in `.cloud` files: little-endian, versioned, checked on reading.
#pragma once

#include <cloudcontact/cloud.h>

#include <filesystem>

namespace cloudcontact {

// Written whole or not at all (a temporary beside it, then renamed). Throws std::runtime_error
// naming the file.
void saveCloud(const Cloud& cloud, const std::filesystem::path& file);

// Throws std::runtime_error that names the file where it is missing, not a cloud, of another
// version, cut short, or says impossible sizes.
Cloud loadCloud(const std::filesystem::path& file);

}  // namespace cloudcontact
