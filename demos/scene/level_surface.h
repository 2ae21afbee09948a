// The surface at which a number known at every place passes zero, as a closed mesh: bodies given by
// a formula, and clouds that were cut, for those who want triangles.
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>

#include <Eigen/Geometry>
#include <functional>

namespace cloudcontact::program {

// Positive inside, of any scale; near its zero it should change about evenly over a cell.
using LevelFunction = std::function<double(const Vec3&)>;

// The level's surface in `box`, in cells of `cell` [m]; what reaches the box is closed there.
// Details finer than a cell are lost. Throws std::invalid_argument where the cell is not positive,
// the box empty, or they make more than 2^28 cells.
Mesh levelSurface(const LevelFunction& inside, const Eigen::AlignedBox3d& box, double cell);

// Where a voxel's coverage passes one half; in blocks of `step` voxels' edge. Empty where there is
// no matter.
Mesh cloudSurface(const Cloud& cloud, int step = 1);

}  // namespace cloudcontact::program
