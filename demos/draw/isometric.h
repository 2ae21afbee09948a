// A cloud's voxels seen from a corner of the grid, where the three axes show equally long.
#pragma once

#include <cloudcontact/field/surface_field.h>

#include <vector>

#include "draw/drawing.h"

namespace cloudcontact::program {

// Who looks stands far off along (1, 1, 1), z is up.
struct IsometricView {
  Vec3 origin = Vec3::Zero();  // shown at `center` [m]
  Point center = Point::Zero();
  double scale = 1;  // [px/m]

  Point toPaper(const Vec3& place) const;
};

// A normal as a colour: red, green and blue are x, y and z, from -1 (none) to 1 (full).
Color normalColor(const Vec3& normal);

// Adds the faces of the voxels that can be seen, and no others, coloured by the field's normals.
// Grids finer than the eye are shown in blocks of several voxels. Returns the scale along the
// axes [px/m].
double addVoxelsFromOutside(Drawing& drawing, const SurfaceField& field, const Rectangle& frame);

// The same for what of a cloud lies in `shown` (the cloud's frame, metres), coloured by its
// materials: `colors` has one for each, or one for all. What is cut by the box shows its inside.
double addMaterialsFromOutside(Drawing& drawing, const Cloud& cloud,
                               const Eigen::AlignedBox3d& shown, const std::vector<Color>& colors,
                               const Rectangle& frame);

// A ball coloured by its normals with the three axes: the key to those colours.
void addNormalBall(Drawing& drawing, const Point& center, double radius);

}  // namespace cloudcontact::program
