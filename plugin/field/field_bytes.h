// A field as bytes within another file, in the layout of `.field` files.
#pragma once

#include <cloudcontact/field/surface_field.h>

#include <cstdint>
#include <filesystem>
#include <iosfwd>

namespace cloudcontact {

constexpr char kFieldMagic[8] = {'C', 'L', 'D', 'F', 'I', 'E', 'L', 'D'};
constexpr std::size_t kFieldLengthAt = 12;  // u64, the number of bytes

// The field must be settled (SurfaceField::unsettled()).
void writeField(const SurfaceField& field, std::ostream& out);
// Reads `size` bytes. Throws std::runtime_error as loadField() does, which names `file`.
std::shared_ptr<const SurfaceField> readField(std::istream& in, std::uint64_t size,
                                              const std::filesystem::path& file);

}  // namespace cloudcontact
