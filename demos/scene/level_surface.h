// The zero level of a function as a closed mesh, for bodies from formulas and for cut clouds.
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>

#include <Eigen/Geometry>
#include <functional>

namespace cloudcontact::program {

// Positive inside, in any scale; it should be about linear over a cell near its zero.
using LevelFunction = std::function<double(const Vec3&)>;

// The zero level in `box`, in cells of `cell` [m], closed at the box. Loses details finer than a
// cell. Throws std::invalid_argument if the cell is not positive, the box is empty, or there are
// more than 2^28 cells.
Mesh levelSurface(const LevelFunction& inside, const Eigen::AlignedBox3d& box, double cell);

// The surface of half coverage, in blocks of `step` voxels' edge. Empty for an empty cloud.
Mesh cloudSurface(const Cloud& cloud, int step = 1);

}  // namespace cloudcontact::program
