// An isometric view of a cloud's voxels.
#pragma once

#include <cloudcontact/field/surface_field.h>

#include <vector>

#include "draw/drawing.h"

namespace cloudcontact::program {

// Parallel projection along -(1, 1, 1), z up.
struct IsometricView {
  Vec3 origin = Vec3::Zero();  // shown at `center` [m]
  Point center = Point::Zero();
  double scale = 1;  // [px/m]

  Point toPaper(const Vec3& place) const;
};

// A normal as a color: red, green and blue for x, y and z, from -1 (dark) to 1 (bright).
Color normalColor(const Vec3& normal);

// Adds the visible faces of the voxels, colored by the field's normals. Merges the voxels of fine
// grids into blocks. Returns the scale along the axes [px/m].
double addVoxelsFromOutside(Drawing& drawing, const SurfaceField& field, const Rectangle& frame);

// The same for the part of a cloud within `shown` (the cloud's frame, meters), colored by material:
// `colors` has one for each, or one for all. The box cuts the cloud open.
double addMaterialsFromOutside(Drawing& drawing, const Cloud& cloud,
                               const Eigen::AlignedBox3d& shown, const std::vector<Color>& colors,
                               const Rectangle& frame);

// Adds a ball colored by its normals with the three axes, as the key to the colors.
void addNormalBall(Drawing& drawing, const Point& center, double radius);

}  // namespace cloudcontact::program
