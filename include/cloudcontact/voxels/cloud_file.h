// Clouds, and any other digital object, kept in `.cloud` files: little-endian, versioned, checked
// on reading.
#pragma once

#include <cloudcontact/objects/digital_object.h>
#include <cloudcontact/voxels/cloud.h>

#include <filesystem>

namespace cloudcontact {

// Written whole or not at all (a temporary beside it, then renamed). Throws std::runtime_error
// naming the file.
void saveCloud(const Cloud& cloud, const std::filesystem::path& file);

// Throws std::runtime_error that names the file where it is missing, not a cloud, of another
// version or another kind of object, cut short, or says impossible sizes.
Cloud loadCloud(const std::filesystem::path& file);

// Any kind of object, as it is; voxels as saveCloud writes them. Throws as that does, and for an
// object that its own check refuses.
void saveObject(const DigitalObject& object, const std::filesystem::path& file);

// What either of the two saved, in the kind that it was. Throws as loadCloud.
DigitalObject loadObject(const std::filesystem::path& file);

}  // namespace cloudcontact
