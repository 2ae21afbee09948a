// Where the voxels of a mesh will lie, and what they will cost.
#pragma once

#include "mesh/closing.h"
#include "voxels/grid_surface.h"

namespace cloudcontact {

// Centred on the body, so that moving a mesh changes no voxel and a symmetric body gets symmetric
// voxels; whole bricks, with at least two empty voxels on every side.
struct Grid {
  double voxelSize = 0;                            // [m]
  Eigen::Vector3d bricks{0, 0, 0};                 // along each axis; may be beyond integers
  Eigen::Vector3d origin{0, 0, 0};                 // [m]
  double places() const { return bricks.prod(); }  // for bricks
};

Grid gridAround(const Mesh& mesh, double voxelSize);

// The surface in voxels, its shells told apart unless it is known to be one.
GridSurface inGrid(const Closing& closing, const Grid& grid, bool oneShell = false);

// What cutting the surface into columns holds at most [bytes]; `passes` is how many copies of the
// result exist at once. Where the empty grid alone takes more than `enough` it looks no closer.
double cuttingBytes(const Closing& closing, double voxelSize, int passes, int threads,
                    double enough);

// The same were every brick to store numbers: an upper bound that costs a look at the vertices.
double fullGridBytes(const Closing& closing, double voxelSize, int passes, int threads);

}  // namespace cloudcontact
