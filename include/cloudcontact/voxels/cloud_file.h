// Clouds in `.cloud` files: little-endian, versioned, with a checksum that is verified on reading.
// Objects of other kinds: objects/object_file.h.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <filesystem>

namespace cloudcontact {

// Writes a temporary file beside `file` and renames it, so that a file is complete or absent.
// Throws std::runtime_error that names the file where it cannot be written or the cloud is empty.
void saveCloud(const Cloud& cloud, const std::filesystem::path& file);

// Throws std::runtime_error that names the file where it is missing, is not a cloud, is of another
// version or another kind of object, is cut short or damaged, or states impossible sizes.
Cloud loadCloud(const std::filesystem::path& file);

}  // namespace cloudcontact
