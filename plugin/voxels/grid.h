// Grid: the future grid of a mesh's voxels, and the memory that they will need.
#pragma once

#include "mesh/closing.h"
#include "voxels/column_cutter.h"

namespace cloudcontact {

// Empty voxels on every side of a cloud: a window of radius 2.5 then lies in its grid.
inline constexpr int kEmptyMargin = 2;

// The grid is centered on the body: moving a mesh changes no voxel, and a symmetric body gets
// symmetric voxels. It has whole bricks, and at least two empty voxels on every side.
struct Grid {
  double voxelSize = 0;                            // [m]
  Eigen::Vector3d bricks{0, 0, 0};                 // along each axis; may exceed the integers
  Eigen::Vector3d origin{0, 0, 0};                 // [m]
  double places() const { return bricks.prod(); }  // number of bricks, full or empty
};

Grid gridAround(const Mesh& mesh, double voxelSize);

// The surface in the grid. Its shells are found unless it is known to be `oneShell`.
GridSurface inGrid(const Closing& closing, const Grid& grid, bool oneShell = false);

// An upper bound of the memory that cutting the surface into columns needs [bytes]. `passes`:
// copies of the result that exist at once. Returns early where the empty table alone exceeds
// `enough`.
double cuttingBytes(const Closing& closing, double voxelSize, int passes, int threads,
                    double enough);

// The same if every brick stored numbers: a coarser bound that takes one pass over the vertices.
double fullGridBytes(const Closing& closing, double voxelSize, int passes, int threads);

}  // namespace cloudcontact
