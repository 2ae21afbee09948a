// Cuts a surface into one brick-wide column of voxel columns: the inner part of columns.cpp, where
// the method is told.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <cstdint>
#include <vector>

#include "base/grid_index.h"
#include "voxels/grid_surface.h"
#include "voxels/polygon.h"

namespace cloudcontact {

constexpr int kColumnsPerBrick = kBrickEdge * kBrickEdge;

// Which axis is which, and where voxels and bricks lie in memory.
struct Frame {
  int u, v, w;
  Eigen::Vector3i bricks;    // of the grid, along x, y, z
  int width, depth, layers;  // bricks along u, v, w

  Frame(const GridSurface& surface, int axis)
      : u((axis + 1) % 3),
        v((axis + 2) % 3),
        w(axis),
        bricks(surface.bricks),
        width(bricks[u]),
        depth(bricks[v]),
        layers(bricks[w]) {}
  static int voxelStride(int axis) { return axis == 0 ? 1 : axis == 1 ? 8 : 64; }
  std::size_t entry(int bu, int bv, int bw) const {
    Eigen::Vector3i b;
    b[u] = bu, b[v] = bv, b[w] = bw;
    return gridIndex(b, bricks);
  }
};

// What one brick-wide column of 8x8 voxel columns became.
struct BrickColumn {
  int firstLayer = 0;
  std::vector<std::int32_t> table;  // from firstLayer on; empty bricks elsewhere
  std::vector<BrickCoverage> coverage;
  std::uint8_t residue[kColumnsPerBrick] = {};  // as in ColumnResult
  int cappedColumns = 0, cappedVoxels = 0;
};

// The running sums of a brick column's 64 columns, and their extremes since they were last asked.
struct Runs {
  double sum[kColumnsPerBrick] = {}, least[kColumnsPerBrick] = {}, most[kColumnsPerBrick] = {};
};

// Cuts one brick-wide column at a time; keeps its memory.
class ColumnCutter {
 public:
  ColumnCutter(const GridSurface& surface, const Frame& frame);

  // Brick column (bu, bv), given the triangles that may touch it.
  BrickColumn cut(int bu, int bv, const int* first, const int* last);

  // What a cutter for columns of so many layers holds [bytes].
  static std::size_t bytes(int layers, bool capped);

 private:
  // A cell's columns stand together, and so eight of them make a register's work.
  double* at(int column, int cell) { return differences_.data() + place(column, cell); }
  static std::size_t place(int column, int cell) {
    return static_cast<std::size_t>(cell) * kColumnsPerBrick + static_cast<std::size_t>(column);
  }
  void touch(int lowestCell, int highestCell);
  void clear();
  CcPolygon inColumn(int bu, int bv, int triangle) const;
  void cutTriangle(int bu, int bv, int triangle);
  void addPiece(int column, int cell, const CcPiece& part);
  void countCaps(BrickColumn& result);
  void sumUp(BrickColumn& result);
  int sumLayer(int layer, Runs& runs, BrickCoverage& brick);
  int codeOf(const BrickCoverage& cells, BrickCoverage& brick) const;
  void unite(int bu, int bv, const int* first, const int* last);

  const GridSurface& surface_;
  const Frame& frame_;
  int height_;  // cells a column, and one more for what a piece in the topmost passes on
  std::vector<double> differences_;
  std::vector<char> touched_;      // layers of bricks whose differences are not all zero
  std::vector<double> caps_;       // projected area of closing triangles in each voxel
  int lowest_ = 0, highest_ = -1;  // cells that hold a piece
  int triangleShell_ = 0;          // of the triangle being cut; -1: it closes the surface
  int shell_[kColumnsPerBrick];    // of each column: -1 none yet, -2 several
  std::uint64_t overlapping_ = 0;  // a bit a column: sums beyond [0, 1], or several shells
};

}  // namespace cloudcontact
