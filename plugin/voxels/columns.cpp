// Depth columns with exact coverage.
//
// The paper reads rectangular parallelepipeds off a Z-buffer (step 1, Fig. 4 a) and cuts them into
// voxels inside, outside and on the interface (Fig. 4 b, c, d). A Z-buffer samples a column by one
// ray. Here the surface is integrated over the column, so an interface voxel holds its true
// fraction of material instead of a yes or no.
//
// Let w be the axis of the columns and u, v the others. The material of a voxel is the sum over all
// surface pieces above it of the volume under them, signed: plus under a piece that faces up (+w),
// minus under one that faces down. Counted from below instead, a piece of signed projected area A
// takes A from every voxel above it and A (1 - f) from the voxel it lies in, where f is the mean
// height of the piece in that voxel. Each triangle is cut at the faces of columns and voxels into
// convex pieces that lie in one voxel each. A piece adds two numbers to its column's list of
// differences, and the running sum along the column is the coverage of each voxel, exact to the
// rounding of doubles. No ray can miss an edge, and a surface exactly on voxel faces is no special
// case.
//
// Where shells lie inside one another or intersect, sums exceed 1 and count as solid;
// column_cutter.cpp handles the voxels for which that is wrong.
//
// The sum over a closed surface returns to zero above the topmost piece. Otherwise the surface has
// a hole in that column, and the column is reported as bad.
#include "voxels/columns.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>

#include "base/parallel.h"

namespace cloudcontact {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// The triangles over each brick-wide column, in their order.
struct Bins {
  std::vector<std::size_t> first;  // one more than there are columns
  std::vector<int> triangles;
};

// Calls visit(column) for each brick-wide column that the triangle's projection may touch.
template <typename Visit>
void forEachBrickColumn(const Frame& frame, const double* p, Visit&& visit) {
  const CcCells rows = ccRowsOf(p, frame.v, frame.depth);
  for (int row = rows.first; row <= rows.last; ++row) {
    const CcCells columns = ccColumnsOf(p, frame.u, frame.v, row, frame.width);
    for (int c = columns.first; c <= columns.last; ++c)
      visit(static_cast<std::size_t>(row) * frame.width + c);
  }
}

Bins binTriangles(const GridSurface& surface, const Frame& frame) {
  Bins bins;
  bins.first.assign(static_cast<std::size_t>(frame.width) * frame.depth + 1, 0);
  const auto forEach = [&](auto&& visit) {
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      const Vector3i& i = surface.triangles[t];
      double p[9];
      for (int k = 0; k < 9; ++k) p[k] = surface.vertices[i[k / 3]][k % 3];
      if (std::abs(ccTwiceArea(p, p + 3, p + 6, frame.u, frame.v)) < CC_SMALLEST_AREA) continue;
      forEachBrickColumn(frame, p, [&](std::size_t c) { visit(c, static_cast<int>(t)); });
    }
  };
  forEach([&](std::size_t c, int) { ++bins.first[c + 1]; });
  for (std::size_t c = 1; c < bins.first.size(); ++c) bins.first[c] += bins.first[c - 1];
  bins.triangles.resize(bins.first.back());
  std::vector<std::size_t> next(bins.first.begin(), bins.first.end() - 1);
  forEach([&](std::size_t c, int t) { bins.triangles[next[c]++] = t; });
  return bins;
}

// Assembles all brick columns in one grid. The order of bricks does not depend on the threads.
ColumnResult assemble(std::vector<BrickColumn>& columns, const Frame& frame) {
  ColumnResult result;
  std::size_t bricks = 0;
  for (const BrickColumn& c : columns) bricks += c.coverage.size();
  result.voxels.bricks = frame.bricks;
  result.voxels.table.assign(static_cast<std::size_t>(frame.width) * frame.depth * frame.layers,
                             kEmptyBrick);
  result.voxels.coverage.reserve(bricks);
  const std::size_t width = static_cast<std::size_t>(frame.width) * kBrickEdge;
  result.residue.assign(width * static_cast<std::size_t>(frame.depth) * kBrickEdge, 0);
  for (int bv = 0, i = 0; bv < frame.depth; ++bv)
    for (int bu = 0; bu < frame.width; ++bu, ++i) {
      BrickColumn& column = columns[i];
      const std::int32_t base = static_cast<std::int32_t>(result.voxels.coverage.size());
      for (std::size_t k = 0; k < column.table.size(); ++k) {
        const std::int32_t b = column.table[k];
        result.voxels.table[frame.entry(bu, bv, column.firstLayer + static_cast<int>(k))] =
            b < 0 ? b : base + b;
      }
      result.voxels.coverage.insert(result.voxels.coverage.end(), column.coverage.begin(),
                                    column.coverage.end());
      result.cappedColumns += column.cappedColumns;
      result.cappedVoxels += column.cappedVoxels;
      for (int c = 0; c < kColumnsPerBrick; ++c) {
        result.badColumns += column.residue[c] > 0;
        result.residue[static_cast<std::size_t>(bu * kBrickEdge + c % kBrickEdge) +
                       width * static_cast<std::size_t>(bv * kBrickEdge + c / kBrickEdge)] =
            column.residue[c];
      }
      column = BrickColumn();  // frees its bricks, so the peak is one copy and one column
    }
  return result;
}

}  // namespace

TouchedBricks touchedBricks(const GridSurface& surface) {
  const Frame frame(surface, 2);
  const Vector3i last = surface.bricks - Vector3i::Ones();
  TouchedBricks bricks;
  bricks.touched.resize(static_cast<std::size_t>(frame.width) * frame.depth * frame.layers);
  for (const Vector3i& t : surface.triangles) {
    CcPolygon triangle;
    triangle.corners = 0;
    for (int k = 0; k < 3; ++k) addCorner(triangle, surface.vertices[t[k]] / kBrickEdge);
    slice<2>(triangle, [&](int z, const CcPolygon& slab) {
      slice<1>(slab, [&](int y, const CcPolygon& bar) {
        slice<0>(bar, [&](int x, const CcPolygon&) {
          const Vector3i b = Vector3i(x, y, z).cwiseMin(last);
          const std::size_t entry = frame.entry(b[0], b[1], b[2]);
          if (bricks.touched[entry]) return;
          bricks.touched[entry] = true;
          ++bricks.count;
        });
      });
    });
  }
  return bricks;
}

int cheapestAxis(const GridSurface& surface) {
  // Every voxel that the surface passes through costs one piece along any axis. But triangles
  // parallel to the axis cost nothing, and fewer columns need less memory.
  double cost[3] = {0, 0, 0};
  for (const Vector3i& t : surface.triangles) {
    const Vector3d &a = surface.vertices[t[0]], &b = surface.vertices[t[1]],
                   &c = surface.vertices[t[2]];
    const Vector3d twice = (b - a).cross(c - a);
    for (int k = 0; k < 3; ++k)
      if (std::abs(twice[k]) >= CC_SMALLEST_AREA) cost[k] += twice.norm() + 1;
  }
  int best = 0;
  for (int k = 1; k < 3; ++k) {
    const bool fewerColumns = surface.bricks[k] > surface.bricks[best];
    if (cost[k] < (fewerColumns ? 1.1 : 0.9) * cost[best]) best = k;
  }
  return best;
}

ColumnResult cutColumns(const GridSurface& surface, int axis, int threads,
                        const std::function<void(double)>& progress) {
  const Frame frame(surface, axis);
  const Bins bins = binTriangles(surface, frame);
  const std::size_t count = bins.first.size() - 1;
  std::vector<BrickColumn> columns(count);
  std::vector<std::unique_ptr<ColumnCutter>> cutters(
      static_cast<std::size_t>(threadCount(threads)));
  std::atomic<std::size_t> done{0};
  parallelFor(count, threads, [&](std::size_t c, int worker) {
    if (bins.first[c] != bins.first[c + 1]) {
      std::unique_ptr<ColumnCutter>& cutter = cutters[worker];
      if (!cutter) cutter = std::make_unique<ColumnCutter>(surface, frame);
      const int bu = static_cast<int>(c % static_cast<std::size_t>(frame.width));
      const int bv = static_cast<int>(c / static_cast<std::size_t>(frame.width));
      columns[c] = cutter->cut(bu, bv, bins.triangles.data() + bins.first[c],
                               bins.triangles.data() + bins.first[c + 1]);
    }
    const std::size_t finished = ++done;
    if (worker == 0 && progress)
      progress(static_cast<double>(finished) / static_cast<double>(count));
  });
  return assemble(columns, frame);
}

}  // namespace cloudcontact
