// Depth and normal of a smooth surface between the planes of its voxels, for queries. Each voxel
// holds one plane; at a radius of 20 voxels their normals are 3 deg apart.
#pragma once

#include <cloudcontact/field/surface_field.h>

namespace cloudcontact {

// The mean of the eight voxels around a point, by the point's distance from their centers. What
// belongs to another face, across an edge or behind a thin wall, is left out. `own`: the field's
// value at the point.
struct SmoothedPoint : FieldPoint {
  bool oneFace;  // nothing was left out
};
SmoothedPoint smoothedPoint(const SurfaceField& field, const Vec3& local, const FieldPoint& own);

}  // namespace cloudcontact
