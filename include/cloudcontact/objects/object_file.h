// Digital objects of any kind in `.cloud` files: little-endian, versioned, with a checksum that is
// verified on reading. Files of voxels are the same as those of voxels/cloud_file.h.
#pragma once

#include <cloudcontact/objects/digital_object.h>

#include <filesystem>

namespace cloudcontact {

// Writes a temporary file beside `file` and renames it, so that a file is complete or absent.
// Throws std::runtime_error that names the file where it cannot be written, and where the object is
// empty or its validate() refuses it.
void saveObject(const DigitalObject& object, const std::filesystem::path& file);

// Reads a file of saveObject() or saveCloud(), as the kind that was saved. Throws
// std::runtime_error as loadCloud() does.
DigitalObject loadObject(const std::filesystem::path& file);

}  // namespace cloudcontact
