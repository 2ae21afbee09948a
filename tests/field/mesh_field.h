// The surface field of a mesh, built on one thread.
#pragma once

#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/voxels/digitize.h>

#include <memory>

namespace cloudcontact::testing {

inline std::shared_ptr<const SurfaceField> fieldOf(const Mesh& mesh, double voxel) {
  DigitizeSettings settings;
  settings.voxelSize = voxel;
  settings.threads = 1;
  FieldSettings field;
  field.threads = 1;
  return SurfaceField::build(digitize(mesh, settings), field);
}

}  // namespace cloudcontact::testing
