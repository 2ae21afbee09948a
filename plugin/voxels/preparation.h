// Prepares a mesh for digitizing, and validates the input and the result.
#pragma once

#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/voxels/digitize_settings.h>

#include <optional>

#include "voxels/grid.h"

namespace cloudcontact {

// The repaired mesh, closed by caps where only small parts are missing.
struct Prepared {
  Closing closing;
  bool wasClosed = false;
  bool closable = false;  // false: large parts are missing, and `closing` has no caps
  bool oneShell = false;  // known to be one closed surface

  // Copies of the voxels that exist at once: one pass and its parts, or three passes and their
  // vote.
  int passes() const { return closable ? 2 : 5; }
};

// The fast path of prepare(), for a mesh that the caller verifies to be one closed surface once its
// vertices are welded (isOneClosedSurface()). Empty where the mesh has no volume.
std::optional<Prepared> preparedAsWhole(const Mesh& mesh);

// Repairs and closes a mesh. Throws std::invalid_argument where it bounds no volume.
Prepared prepare(const Mesh& mesh);

// Throw std::invalid_argument on an unusable setting.
void validateVoxelSize(double voxelSize);
void validate(const DigitizeSettings& settings);

// Throws std::length_error where that many copies of the voxels would exceed settings.maxBytes. The
// message names a voxel size that fits.
void checkSize(const Prepared& prepared, const DigitizeSettings& settings, int passes);

// Throws std::invalid_argument where all voxels are empty.
void checkNotEmpty(const Cloud::Voxels& voxels, const Prepared& prepared, double voxelSize);

}  // namespace cloudcontact
