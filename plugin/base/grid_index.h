// The one order of cells in memory. A dense grid stores its cells with x fastest. A sparse grid of
// voxels consists of bricks of 8 x 8 x 8 voxels: a table with an entry for each brick, and in each
// stored brick 512 cells, both with x fastest.
#pragma once

#include <Eigen/Core>
#include <cstddef>

namespace cloudcontact {

constexpr double kHalfDiagonal = 0.8660254037844387;  // of a unit cube

// Index of cell (x, y, z) in a grid of `size` cells: x + nx (y + ny z).
inline std::size_t gridIndex(int x, int y, int z, const Eigen::Vector3i& size) {
  return static_cast<std::size_t>(x) +
         static_cast<std::size_t>(size[0]) *
             (static_cast<std::size_t>(y) +
              static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(z));
}
inline std::size_t gridIndex(const Eigen::Vector3i& cell, const Eigen::Vector3i& size) {
  return gridIndex(cell[0], cell[1], cell[2], size);
}

// The cell at `index`: the inverse of gridIndex().
inline Eigen::Vector3i gridCell(std::size_t index, const Eigen::Vector3i& size) {
  const auto nx = static_cast<std::size_t>(size[0]), ny = static_cast<std::size_t>(size[1]);
  return {static_cast<int>(index % nx), static_cast<int>(index / nx % ny),
          static_cast<int>(index / nx / ny)};
}

// Whether a grid of `size` cells has the cell (x, y, z).
inline bool insideGrid(int x, int y, int z, const Eigen::Vector3i& size) {
  return x >= 0 && y >= 0 && z >= 0 && x < size[0] && y < size[1] && z < size[2];
}
inline bool insideGrid(const Eigen::Vector3i& cell, const Eigen::Vector3i& size) {
  return insideGrid(cell[0], cell[1], cell[2], size);
}

// Index of a voxel's brick in the table of a grid of `bricks`. The voxel must lie in the grid.
inline std::size_t brickIndex(int x, int y, int z, const Eigen::Vector3i& bricks) {
  return gridIndex(x >> 3, y >> 3, z >> 3, bricks);
}
inline std::size_t brickIndex(const Eigen::Vector3i& voxel, const Eigen::Vector3i& bricks) {
  return brickIndex(voxel[0], voxel[1], voxel[2], bricks);
}

// Index of a voxel's cell in its brick, 0..511; also of voxels with negative coordinates.
constexpr int cellIndex(int x, int y, int z) {
  return (x & 7) | (y & 7) << 3 | (z & 7) << 6;
}
inline int cellIndex(const Eigen::Vector3i& voxel) {
  return cellIndex(voxel[0], voxel[1], voxel[2]);
}

// The place of a cell in its brick, from the brick's first voxel: the inverse of cellIndex().
inline Eigen::Vector3i cellOffset(int cell) {
  return {cell & 7, cell >> 3 & 7, cell >> 6};
}

}  // namespace cloudcontact
