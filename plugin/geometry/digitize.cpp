// From a mesh to a cloud: mend the surface, close what is open, cut it into columns (columns.cpp).
#include <cloudcontact/digitize.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "geometry/closing.h"
#include "geometry/columns.h"
#include "geometry/mesh_topology.h"

namespace cloudcontact {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Empty voxels around the body, so that a window of radius 2.5 finds its neighbours in the grid.
constexpr int kMargin = 2;

void checkSettings(const DigitizeSettings& settings) {
  if (!(settings.voxelSize > 0) || !std::isfinite(settings.voxelSize)) {
    std::ostringstream message;
    message << "digitize: voxelSize is " << settings.voxelSize
            << ", must be positive and finite [m]";
    throw std::invalid_argument(message.str());
  }
  if (settings.threads < 0)
    throw std::invalid_argument("digitize: threads must be 0 (all cores) or positive");
}

// Where the grid lies: centred on the body, so that moving a mesh changes no voxel and a symmetric
// body gets symmetric voxels.
struct Grid {
  Vector3d bricks = Vector3d::Zero();  // as numbers, for they may be too many for integers
  Vector3d origin = Vector3d::Zero();  // [m]
};

Grid gridAround(const Mesh& mesh, double h) {
  Vector3d low = mesh.vertices.front(), high = low;
  for (const Vector3i& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      low = low.cwiseMin(mesh.vertices[t[k]]);
      high = high.cwiseMax(mesh.vertices[t[k]]);
    }
  Grid grid;
  // A whole number of voxels that rounding lifted a hair above it does not ask for another brick.
  constexpr double kHair = 1e-9;
  grid.bricks = (((high - low) / h).array() + (2 * kMargin - kHair)).matrix() / double{kBrickEdge};
  grid.bricks = grid.bricks.array().ceil().max(1);
  grid.origin = low + 0.5 * (high - low) - 0.5 * h * kBrickEdge * grid.bricks;
  return grid;
}

GridSurface inGrid(const Mesh& mesh, std::size_t firstCap, const Grid& grid, double h) {
  GridSurface surface;
  surface.bricks = grid.bricks.cast<int>();
  surface.vertices.reserve(mesh.vertices.size());
  const Vector3d highest = kBrickEdge * grid.bricks;
  for (const Vector3d& v : mesh.vertices)
    surface.vertices.push_back(
        ((v - grid.origin) / h).cwiseMax(Vector3d::Zero()).cwiseMin(highest));
  surface.triangles = mesh.triangles;
  surface.firstCap = firstCap;
  return surface;
}

}  // namespace

std::size_t digitizeBytes(const Mesh& mesh, double voxelSize) {
  (void)mesh, (void)voxelSize;
  return 0;
}

Cloud digitize(const Mesh& mesh, const DigitizeSettings& settings, DigitizeReport* report) {
  checkSettings(settings);
  if (mesh.triangles.empty()) throw std::invalid_argument("digitize: the mesh has no triangles");
  const Mesh surface = mended(mesh);
  if (surface.triangles.empty())
    throw std::invalid_argument("digitize: every triangle of the mesh is a line or a point");
  const Grid grid = gridAround(surface, settings.voxelSize);
  const Closing closing = closeSurface(surface);
  DigitizeReport found;
  found.closed = closing.wasClosed();
  const GridSurface inVoxels = inGrid(closing.mesh, closing.firstCap, grid, settings.voxelSize);
  ColumnResult columns =
      cutColumns(inVoxels, cheapestAxis(inVoxels), settings.threads, settings.progress);
  found.badColumns = columns.cappedColumns;
  found.undecidedVoxels = columns.cappedVoxels;
  if (report) *report = found;
  return Cloud(settings.voxelSize, grid.origin,
               std::make_shared<Cloud::Voxels>(std::move(columns.voxels)));
}

}  // namespace cloudcontact
