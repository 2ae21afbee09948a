// The picture of `digitize --picture`: a body's voxels in slices and from outside.
#pragma once

#include <cloudcontact/field/surface_field.h>

#include <memory>
#include <string>

#include "draw/drawing.h"

namespace cloudcontact::program {

Drawing cloudPicture(const std::string& name, std::shared_ptr<const SurfaceField> field);

}  // namespace cloudcontact::program
