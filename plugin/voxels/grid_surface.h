// GridSurface: a surface placed in the grid of its future voxels.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace cloudcontact {

struct GridSurface {
  Eigen::Vector3i bricks;                  // bricks of the grid, which encloses all vertices
  std::vector<Eigen::Vector3d> vertices;   // in the grid's frame [voxels]
  std::vector<Eigen::Vector3i> triangles;  // those of the mesh, then the caps that close it
  std::size_t firstCap = 0;                // index of the first cap
  // The shell of each of the mesh's own triangles; empty where there is only one shell.
  std::vector<int> component;
};

}  // namespace cloudcontact
