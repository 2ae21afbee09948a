// Surface fields in `.field` files, so that a program need not build them at each start:
// little-endian, versioned, with a checksum that is verified on reading. A file holds the cloud
// too.
#pragma once

#include <cloudcontact/field/surface_field.h>

#include <filesystem>

namespace cloudcontact {

// Writes a temporary file beside `file` and renames it, so that a file is complete or absent. What
// only renewed() needs is not stored. Throws std::runtime_error that names the file where it cannot
// be written, and where edges of the field are still to be searched (SurfaceField::unsettled()).
void saveField(const SurfaceField& field, const std::filesystem::path& file);

// The field that was saved, with the same hash(). As it is not renewable, renewed() builds it
// again. Throws std::runtime_error that names the file where it is missing, is not a field, is of
// another version, is cut short or damaged, or states impossible sizes.
std::shared_ptr<const SurfaceField> loadField(const std::filesystem::path& file);

}  // namespace cloudcontact
