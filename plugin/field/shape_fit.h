// Fits shapes to points of a surface by least squares.
#pragma once

#include <cloudcontact/law/solid.h>

#include <vector>

namespace cloudcontact {

// A point of a surface. Lengths in any unit, about the size of the numbers in a grid of voxels.
struct ShapePoint {
  Vec3 position = Vec3::Zero(), normal = Vec3::Zero();  // outward, unit
  double area = 0;
};

// One shape of each kind that the points may be of, each the best of its kind: ball, box, cylinder,
// capsule, cone. Kinds that the points cannot be of are missing, as are those from which some of
// the points are farther than `most`, root mean square.
std::vector<PlacedSolid> fittedShapes(const std::vector<ShapePoint>& surface, double most);

}  // namespace cloudcontact
