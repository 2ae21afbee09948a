// CT volumes from files: NRRD (.nrrd, or .nhdr with its data beside it) and MetaImage (.mha, or
// .mhd with its data beside it), raw or compressed by gzip. Part of the target CloudContact::files.
#pragma once

#include <cloudcontact/voxels/ct_volume.h>

#include <filesystem>

namespace cloudcontact {

// How the values of a file become a volume.
struct VolumeFileSettings {
  double metersPerUnit = 1;  // of lengths whose unit the file does not state
  // Voxels that the values shall become [m]. Where they are at least twice as wide as the spacing,
  // whole blocks of values become their mean while the file is read. 0: no blocks.
  double voxelSize = 0;
  std::size_t maxBytes = std::size_t{4} << 30;  // of CtVolume::values
};

// Whether a file has the extension of a volume.
bool isVolumeFile(const std::filesystem::path& file);

// The values of a file. Axes that run against x, y or z, or in another order, are turned; without
// an origin the center of the first value is 0. Throws std::runtime_error that names the file, the
// fault and what to do: missing, no header of these formats, a field that is missing or wrong,
// oblique axes, fewer or more data than the sizes say, values that are not finite;
// std::length_error that names a voxel that fits where the values need more than `maxBytes`.
CtVolume loadVolume(const std::filesystem::path& file, const VolumeFileSettings& settings = {});

}  // namespace cloudcontact
