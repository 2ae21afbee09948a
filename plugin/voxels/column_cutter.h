// ColumnCutter: cuts a surface into one brick-wide column of 8x8 voxel columns. The inner loop of
// columns.cpp, which describes the method.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <cstdint>
#include <vector>

#include "base/grid_index.h"
#include "kernels/digitize/column_cut.h"

namespace cloudcontact {

// A surface placed in the grid of its future voxels.
struct GridSurface {
  Eigen::Vector3i bricks;                  // bricks of the grid, which encloses all vertices
  std::vector<Eigen::Vector3d> vertices;   // in the grid's frame [voxels]
  std::vector<Eigen::Vector3i> triangles;  // those of the mesh, then the caps that close it
  std::size_t firstCap = 0;                // index of the first cap
  // The shell of each of the mesh's own triangles; empty where there is only one shell.
  std::vector<int> component;
};

// Convex polygons, cut at whole numbers of one coordinate (kernels/digitize/column_cut.h).
inline void addCorner(CcPolygon& polygon, const Eigen::Vector3d& x) {
  ccAddCorner(&polygon, x.data());
}

// Calls visit(cell, piece) for the pieces of `polygon` between whole numbers of x[Axis].
template <int Axis, typename Visit>
void slice(const CcPolygon& polygon, Visit&& visit) {
  const CcCells cells = ccCells(&polygon, Axis);
  if (cells.first == cells.last) return visit(cells.first, polygon);
  CcPolygon buffers[2], piece;
  const CcPolygon* rest = &polygon;
  for (int cell = cells.first; cell < cells.last; ++cell) {
    CcPolygon& above = buffers[cell & 1];
    ccSplit(rest, Axis, cell + 1, &piece, &above);
    if (piece.corners > 2) visit(cell, piece);
    rest = &above;
  }
  if (rest->corners > 2) visit(cells.last, *rest);
}

// As slice<2>(), but visits only the sums of the pieces.
template <typename Visit>
void forEachPiece(const CcPolygon& polygon, Visit&& visit) {
  const CcCells cells = ccCells(&polygon, 2);
  CcPolygon buffers[2];
  CcFan below;
  const CcPolygon* rest = &polygon;
  for (int cell = cells.first; cell < cells.last; ++cell) {
    CcPolygon& above = buffers[cell & 1];
    ccCutCell(rest, cell, &below, &above);
    if (below.corners > 2) visit(cell, ccPieceOfFan(&below));
    rest = &above;
  }
  if (rest->corners > 2) visit(cells.last, ccPieceOf(rest, cells.last));
}

constexpr int kColumnsPerBrick = kBrickEdge * kBrickEdge;

// The axes of the columns, and the place of bricks in the table.
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

// The voxels of one brick-wide column.
struct BrickColumn {
  int firstLayer = 0;
  std::vector<std::int32_t> table;  // from firstLayer up; other bricks are empty
  std::vector<BrickCoverage> coverage;
  std::uint8_t residue[kColumnsPerBrick] = {};  // as in ColumnResult
  int cappedColumns = 0, cappedVoxels = 0;
};

// The running sums of the 64 columns, and their extremes so far.
struct Runs {
  double sum[kColumnsPerBrick] = {}, least[kColumnsPerBrick] = {}, most[kColumnsPerBrick] = {};
};

// Cuts one brick-wide column at a time and reuses its memory.
class ColumnCutter {
 public:
  ColumnCutter(const GridSurface& surface, const Frame& frame);

  // Cuts brick column (bu, bv) by the triangles that may touch it.
  BrickColumn cut(int bu, int bv, const int* first, const int* last);

  // Memory of a cutter for columns of this many layers [bytes].
  static std::size_t bytes(int layers, bool capped);

 private:
  // The columns of a cell are adjacent, so eight of them fill a SIMD register.
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
  int height_;  // cells per column, plus one for what a piece in the topmost cell passes on
  std::vector<double> differences_;
  std::vector<char> touched_;      // layers of bricks whose differences are not all zero
  std::vector<double> caps_;       // projected area of closing triangles in each voxel
  int lowest_ = 0, highest_ = -1;  // range of cells that hold a piece
  int triangleShell_ = 0;          // of the current triangle; -1: a cap
  int shell_[kColumnsPerBrick];    // per column: -1 none yet, -2 several
  std::uint64_t overlapping_ = 0;  // bit per column: sums beyond [0, 1], or several shells
};

}  // namespace cloudcontact
