// Grids of meshes and their memory: see grid.h.
#include "voxels/grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mesh/mesh_topology.h"
#include "voxels/columns.h"

namespace cloudcontact {

using Eigen::Vector3d;
using Eigen::Vector3i;

namespace {

// Tolerance that keeps rounding errors from adding a brick.
constexpr double kBrickHair = 1e-9;
// In larger grids [bricks] the bricks of the surface are estimated: counting takes a bit per brick.
constexpr double kCountable = 1 << 28;

// An upper bound of the number of bricks that the surface passes through.
double brickBound(const Mesh& mesh, double voxelSize) {
  const double s = voxelSize * kBrickEdge;
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vector3i& i = mesh.triangles[t];
    const Vector3d &a = mesh.vertices[i[0]], &b = mesh.vertices[i[1]], &c = mesh.vertices[i[2]];
    const Vector3d box = (a.cwiseMax(b).cwiseMax(c) - a.cwiseMin(b).cwiseMin(c)) / s;
    // These bricks lie within a brick's diagonal of the triangle: in a prism, half cylinders along
    // the edges and parts of a ball at the corners.
    const double length = ((b - a).norm() + (c - b).norm() + (a - c).norm()) / s;
    const double near =
        2 * std::sqrt(3.0) * triangleArea(mesh, t) / (s * s) + 1.5 * std::numbers::pi * length + 22;
    sum += std::min((box.array() + 2).prod(), near);
  }
  return sum;
}

// The surface in voxels, without its shells.
GridSurface placed(const Closing& closing, const Grid& grid) {
  const Mesh& mesh = closing.mesh;
  GridSurface surface;
  surface.bricks = grid.bricks.cast<int>();
  surface.vertices.reserve(mesh.vertices.size());
  const Vector3d highest = kBrickEdge * grid.bricks;
  for (const Vector3d& v : mesh.vertices)
    surface.vertices.push_back(
        ((v - grid.origin) / grid.voxelSize).cwiseMax(Vector3d::Zero()).cwiseMin(highest));
  surface.triangles = mesh.triangles;
  surface.firstCap = closing.firstCap;
  return surface;
}

double tableBytes(const Grid& grid) {
  return sizeof(std::int32_t) * grid.places();
}

// Memory for cutting where that many bricks store numbers.
double bytesOf(const Closing& closing, const Grid& grid, double bricks, int passes, int threads) {
  const double layers = std::min(grid.bricks.maxCoeff(), 1e8);
  const double columns = grid.places() / grid.bricks.minCoeff();
  const double scratch = ColumnCutter::bytes(static_cast<int>(layers), true);
  // The record of a brick column, and the residues of its columns.
  constexpr double kColumnBytes = sizeof(BrickColumn) + 8 + kColumnsPerBrick;
  // Topology and copies of the mesh, and the lists of triangles per column.
  constexpr double kTriangleBytes = 400;
  return passes * (tableBytes(grid) + kBrickVoxels * bricks) + kColumnBytes * columns +
         threads * scratch + kTriangleBytes * static_cast<double>(closing.mesh.triangles.size()) +
         8 * bricks;
}

}  // namespace

Grid gridAround(const Mesh& mesh, double voxelSize) {
  Vector3d low = Vector3d::Constant(INFINITY), high = -low;
  for (const Vector3i& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      low = low.cwiseMin(mesh.vertices[t[k]]);
      high = high.cwiseMax(mesh.vertices[t[k]]);
    }
  Grid grid;
  grid.voxelSize = voxelSize;
  const Vector3d extent = (high - low) / voxelSize;
  grid.bricks = ((extent.array() + (2 * kEmptyMargin - kBrickHair)) / kBrickEdge).ceil();
  grid.origin = low + 0.5 * (high - low) - 0.5 * voxelSize * kBrickEdge * grid.bricks;
  return grid;
}

GridSurface inGrid(const Closing& closing, const Grid& grid, bool oneShell) {
  GridSurface surface = placed(closing, grid);
  if (oneShell) return surface;
  int shells = 0;
  surface.component = components(closing.mesh, shells);
  if (shells < 2) surface.component.clear();
  return surface;
}

double cuttingBytes(const Closing& closing, double voxelSize, int passes, int threads,
                    double enough) {
  const Grid grid = gridAround(closing.mesh, voxelSize);
  const double table = passes * tableBytes(grid);
  if (!(table <= enough)) return table;
  double bricks = std::min(brickBound(closing.mesh, voxelSize), grid.places());
  if (grid.places() <= kCountable)
    bricks = std::min(bricks, static_cast<double>(touchedBricks(placed(closing, grid)).count));
  return bytesOf(closing, grid, bricks, passes, threads);
}

double fullGridBytes(const Closing& closing, double voxelSize, int passes, int threads) {
  const Grid grid = gridAround(closing.mesh, voxelSize);
  return bytesOf(closing, grid, grid.places(), passes, threads);
}

}  // namespace cloudcontact
