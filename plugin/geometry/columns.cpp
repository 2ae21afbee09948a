// Depth columns with exact coverage.
//
// The paper represents a body as rectangular parallelepipeds read off a Z-buffer (step 1, Fig. 4 a)
// and then cuts those into voxels that lie inside, outside or on the interface (Fig. 4 b, c, d). A
// Z-buffer sees a column through one ray; here the whole column is seen, so that an interface voxel
// holds its true fraction of material and not a ray's yes or no.
//
// Let w be the axis of the columns and u, v the others. The material of a voxel is the sum over all
// surface pieces above it of the volume under them, signed: plus under a piece that faces up (+w),
// minus under one that faces down. Counted from below instead, a piece of signed projected area A
// takes A from every voxel above it and A (1 - f) from the voxel it lies in, where f is the mean
// height of the piece in that voxel. So each triangle is cut at the faces of columns and voxels
// into convex pieces that lie in one voxel each; a piece adds two numbers to its column's list of
// differences; and the running sum along the column is the coverage of each voxel, exact to the
// rounding of doubles. It needs no ray to hit or miss an edge, and a surface that lies exactly on
// voxel faces is no special case.
//
// The sum of a closed surface comes back to zero above the topmost piece. Where it does not, the
// surface has a hole in that column, and the column is reported as bad.
#include "geometry/columns.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>

#include "geometry/parallel.h"

namespace cloudcontact {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr int kColumnsPerBrick = kBrickEdge * kBrickEdge;
// Smallest projected area of a triangle that is cut [voxel^2]: what is less changes no voxel, even
// summed over a million triangles, and is the rounding of a face that is parallel to the columns.
constexpr double kSmallestArea = 1e-12;
// Largest sum that a closed surface may leave at a column's end [voxel^2]. A 1/255 step of coverage
// is 4e-3; rounding leaves 1e-12.
constexpr double kClosedSum = 1e-6;
// Projected area of closing triangles in a voxel that counts as their having decided it [voxel^2].
constexpr double kCapArea = 1e-3;

// A convex polygon. A triangle cut by at most six planes has at most nine corners; the room beyond
// is for slivers that rounding makes cross a plane more than twice, and what they have beyond that
// room has no area to lose.
struct Polygon {
  static constexpr int kMost = 16;
  int corners = 0;
  Vector3d p[kMost];
  void add(const Vector3d& x) {
    if (corners < kMost) p[corners++] = x;
  }
};

// The parts of `polygon` below and above the plane x[axis] = value. Corners on the plane go to
// both, so that an area of zero may come out, never a gap.
void split(const Polygon& polygon, int axis, double value, Polygon& below, Polygon& above) {
  below.corners = above.corners = 0;
  for (int i = 0; i < polygon.corners; ++i) {
    const Vector3d& a = polygon.p[i];
    const Vector3d& b = polygon.p[i + 1 < polygon.corners ? i + 1 : 0];
    const double da = a[axis] - value, db = b[axis] - value;
    if (da <= 0) below.add(a);
    if (da >= 0) above.add(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
      Vector3d x = a + (da / (da - db)) * (b - a);
      x[axis] = value;
      below.add(x);
      above.add(x);
    }
  }
}

// Calls visit(cell, piece) for the pieces of `polygon` between whole numbers of x[axis].
template <typename Visit>
void slice(const Polygon& polygon, int axis, Visit&& visit) {
  double low = polygon.p[0][axis], high = low;
  for (int i = 1; i < polygon.corners; ++i) {
    low = std::min(low, polygon.p[i][axis]);
    high = std::max(high, polygon.p[i][axis]);
  }
  const int first = static_cast<int>(std::floor(low));
  const int last = std::max(first, static_cast<int>(std::ceil(high)) - 1);
  if (first == last) return visit(first, polygon);
  Polygon buffers[2], piece;
  const Polygon* rest = &polygon;
  for (int cell = first; cell < last; ++cell) {
    Polygon& above = buffers[cell & 1];
    split(*rest, axis, cell + 1, piece, above);
    if (piece.corners > 2) visit(cell, piece);
    rest = &above;
  }
  if (rest->corners > 2) visit(last, *rest);
}

// Twice the projected area, positive where the triangle faces up.
double twiceProjectedArea(const Vector3d& a, const Vector3d& b, const Vector3d& c, int u, int v) {
  return (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
}

// Which axis is which, and where voxels and bricks lie in memory.
struct Frame {
  int u, v, w;
  Vector3i bricks;           // of the grid, along x, y, z
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
    Vector3i b;
    b[u] = bu, b[v] = bv, b[w] = bw;
    return static_cast<std::size_t>(b[0]) +
           static_cast<std::size_t>(bricks[0]) *
               (static_cast<std::size_t>(b[1]) + static_cast<std::size_t>(bricks[1]) * b[2]);
  }
};

// For each brick-wide column the triangles over it, in their order.
struct Bins {
  std::vector<std::size_t> first;  // one more than there are columns
  std::vector<int> triangles;
};

// Calls visit(column) for each brick-wide column that the triangle's projection may touch: row by
// row, so that a long oblique triangle is listed along its length and not all over its box.
template <typename Visit>
void forEachBrickColumn(const Frame& frame, const Vector3d (&p)[3], Visit&& visit) {
  constexpr double kSlack = 1e-6;  // a column too many costs time, one too few a hole
  const auto brick = [](double x, int count) {
    return std::clamp(static_cast<int>(std::floor(x / kBrickEdge)), 0, count - 1);
  };
  const auto [lowV, highV] = std::minmax({p[0][frame.v], p[1][frame.v], p[2][frame.v]});
  for (int row = brick(lowV - kSlack, frame.depth); row <= brick(highV + kSlack, frame.depth);
       ++row) {
    const double below = row * kBrickEdge - kSlack, above = (row + 1) * kBrickEdge + kSlack;
    double lowU = 1e300, highU = -1e300;
    const auto reach = [&](double x) { lowU = std::min(lowU, x), highU = std::max(highU, x); };
    for (int k = 0; k < 3; ++k) {
      const Vector3d &a = p[k], &b = p[(k + 1) % 3];
      if (a[frame.v] >= below && a[frame.v] <= above) reach(a[frame.u]);
      for (const double line : {below, above})
        if ((a[frame.v] < line) != (b[frame.v] < line))
          reach(a[frame.u] +
                (line - a[frame.v]) / (b[frame.v] - a[frame.v]) * (b[frame.u] - a[frame.u]));
    }
    if (lowU > highU) continue;
    for (int c = brick(lowU - kSlack, frame.width); c <= brick(highU + kSlack, frame.width); ++c)
      visit(static_cast<std::size_t>(row) * frame.width + c);
  }
}

Bins binTriangles(const GridSurface& surface, const Frame& frame) {
  Bins bins;
  bins.first.assign(static_cast<std::size_t>(frame.width) * frame.depth + 1, 0);
  const auto forEach = [&](auto&& visit) {
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      const Vector3i& i = surface.triangles[t];
      const Vector3d p[3] = {surface.vertices[i[0]], surface.vertices[i[1]],
                             surface.vertices[i[2]]};
      if (std::abs(twiceProjectedArea(p[0], p[1], p[2], frame.u, frame.v)) < kSmallestArea)
        continue;
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

// What one brick-wide column of 8x8 voxel columns became.
struct BrickColumn {
  int firstLayer = 0;
  std::vector<std::int32_t> table;  // from firstLayer on; empty bricks elsewhere
  std::vector<BrickCoverage> coverage;
  std::uint64_t bad = 0;  // a bit a voxel column
  int cappedColumns = 0, cappedVoxels = 0;
};

// Cuts one brick-wide column at a time; keeps its memory.
class Cutter {
 public:
  Cutter(const GridSurface& surface, const Frame& frame)
      : surface_(surface),
        frame_(frame),
        height_(frame.layers * kBrickEdge + 1),
        differences_(static_cast<std::size_t>(kColumnsPerBrick) * height_, 0.0) {
    if (surface.firstCap < surface.triangles.size()) caps_.resize(differences_.size(), 0.0);
  }

  BrickColumn cut(int bu, int bv, const int* first, const int* last) {
    lowest_ = height_, highest_ = -1;
    for (const int* t = first; t != last; ++t) cutTriangle(bu, bv, *t);
    BrickColumn result;
    if (highest_ < 0) return result;
    countCaps(result);
    sumUp(result);
    for (int c = 0; c < kColumnsPerBrick; ++c)
      std::fill(at(c, lowest_), at(c, std::min(highest_ + 2, height_)), 0.0);
    return result;
  }

 private:
  double* at(int column, int cell) {
    return differences_.data() + static_cast<std::size_t>(column) * height_ + cell;
  }

  void cutTriangle(int bu, int bv, int t) {
    const Vector3i& i = surface_.triangles[t];
    isCap_ = static_cast<std::size_t>(t) >= surface_.firstCap;
    // From here on the brick column's own corner is (0, 0), its axes u, v, w the first three.
    Polygon polygon;
    for (int k = 0; k < 3; ++k) {
      const Vector3d& p = surface_.vertices[i[k]];
      polygon.add({p[frame_.u] - bu * kBrickEdge, p[frame_.v] - bv * kBrickEdge, p[frame_.w]});
    }
    Polygon other, unused;
    split(polygon, 0, 0, unused, other);
    split(other, 0, kBrickEdge, polygon, unused);
    split(polygon, 1, 0, unused, other);
    split(other, 1, kBrickEdge, polygon, unused);
    if (polygon.corners < 3) return;
    slice(polygon, 1, [&](int v, const Polygon& row) {
      slice(row, 0, [&](int u, const Polygon& column) {
        const int c = std::min(u, kBrickEdge - 1) + kBrickEdge * std::min(v, kBrickEdge - 1);
        slice(column, 2, [&](int w, const Polygon& piece) { addPiece(c, w, piece); });
      });
    });
  }

  void addPiece(int column, int cell, const Polygon& piece) {
    double twiceArea = 0, sixMoments = 0;
    const Vector3d& a = piece.p[0];
    for (int i = 2; i < piece.corners; ++i) {
      const Vector3d &b = piece.p[i - 1], &c = piece.p[i];
      const double cross = twiceProjectedArea(a, b, c, 0, 1);
      twiceArea += cross;
      sixMoments += cross * ((a[2] - cell) + (b[2] - cell) + (c[2] - cell));
    }
    const double area = twiceArea / 2, under = sixMoments / 6;
    double* d = at(column, cell);
    d[0] -= area - under;
    d[1] -= under;
    lowest_ = std::min(lowest_, cell);
    highest_ = std::max(highest_, cell);
    if (isCap_) caps_[static_cast<std::size_t>(column) * height_ + cell] += std::abs(area);
  }

  void countCaps(BrickColumn& result) {
    if (caps_.empty()) return;
    for (int c = 0; c < kColumnsPerBrick; ++c) {
      int voxels = 0;
      for (int w = lowest_; w <= highest_; ++w) {
        double& area = caps_[static_cast<std::size_t>(c) * height_ + w];
        voxels += area > kCapArea;
        area = 0;
      }
      result.cappedVoxels += voxels;
      result.cappedColumns += voxels > 0;
    }
  }

  // Running sums, layer of bricks by layer, and the bricks they make.
  void sumUp(BrickColumn& result) {
    double run[kColumnsPerBrick] = {};
    result.firstLayer = lowest_ / kBrickEdge;
    // The sums end one cell above the topmost piece.
    const int lastLayer = std::min(highest_ + 1, height_ - 2) / kBrickEdge;
    BrickCoverage brick;
    for (int layer = result.firstLayer; layer <= lastLayer; ++layer) {
      int least = 255, most = 0;
      for (int c = 0; c < kColumnsPerBrick; ++c) {
        const double* d = at(c, layer * kBrickEdge);
        int place = c % kBrickEdge * Frame::voxelStride(frame_.u) +
                    c / kBrickEdge * Frame::voxelStride(frame_.v);
        for (int w = 0; w < kBrickEdge; ++w, place += Frame::voxelStride(frame_.w)) {
          run[c] += d[w];
          const int coverage = static_cast<int>(std::clamp(run[c], 0.0, 1.0) * 255 + 0.5);
          least = std::min(least, coverage);
          most = std::max(most, coverage);
          brick[static_cast<std::size_t>(place)] = static_cast<std::uint8_t>(coverage);
        }
      }
      if (most == 0 || least == 255) {
        result.table.push_back(most == 0 ? kEmptyBrick : kSolidBrick);
      } else {
        result.table.push_back(static_cast<std::int32_t>(result.coverage.size()));
        result.coverage.push_back(brick);
      }
    }
    for (int c = 0; c < kColumnsPerBrick; ++c)
      if (std::abs(run[c]) > kClosedSum) result.bad |= std::uint64_t{1} << c;
  }

  const GridSurface& surface_;
  const Frame& frame_;
  int height_;  // cells a column, and one more for what a piece in the topmost passes on
  std::vector<double> differences_, caps_;
  int lowest_ = 0, highest_ = -1;  // cells that hold a piece
  bool isCap_ = false;
};

// All brick columns in one grid. The order of bricks is that of the columns, whoever cut them.
ColumnResult assemble(std::vector<BrickColumn>& columns, const Frame& frame) {
  ColumnResult result;
  std::size_t bricks = 0;
  for (const BrickColumn& c : columns) bricks += c.coverage.size();
  result.voxels.bricks = frame.bricks;
  result.voxels.table.assign(static_cast<std::size_t>(frame.width) * frame.depth * frame.layers,
                             kEmptyBrick);
  result.voxels.coverage.reserve(bricks);
  const std::size_t width = static_cast<std::size_t>(frame.width) * kBrickEdge;
  result.bad.assign(width * static_cast<std::size_t>(frame.depth) * kBrickEdge, 0);
  for (int bv = 0, i = 0; bv < frame.depth; ++bv)
    for (int bu = 0; bu < frame.width; ++bu, ++i) {
      BrickColumn& column = columns[static_cast<std::size_t>(i)];
      const std::int32_t base = static_cast<std::int32_t>(result.voxels.coverage.size());
      for (std::size_t k = 0; k < column.table.size(); ++k) {
        const std::int32_t b = column.table[k];
        result.voxels.table[frame.entry(bu, bv, column.firstLayer + static_cast<int>(k))] =
            b < 0 ? b : base + b;
      }
      result.voxels.coverage.insert(result.voxels.coverage.end(), column.coverage.begin(),
                                    column.coverage.end());
      result.cappedColumns += static_cast<std::size_t>(column.cappedColumns);
      result.cappedVoxels += static_cast<std::size_t>(column.cappedVoxels);
      for (int c = 0; column.bad && c < kColumnsPerBrick; ++c)
        if (column.bad >> c & 1) {
          ++result.badColumns;
          result.bad[static_cast<std::size_t>(bu * kBrickEdge + c % kBrickEdge) +
                     width * static_cast<std::size_t>(bv * kBrickEdge + c / kBrickEdge)] = 1;
        }
      column = BrickColumn();  // frees its bricks: the peak is one copy and a column
    }
  return result;
}

}  // namespace

int cheapestAxis(const GridSurface& surface) {
  // Every voxel that the surface passes through costs one piece, whatever the axis; but triangles
  // parallel to the axis cost nothing, and fewer columns mean less scratch.
  double cost[3] = {0, 0, 0};
  for (const Vector3i& t : surface.triangles) {
    const Vector3d &a = surface.vertices[t[0]], &b = surface.vertices[t[1]],
                   &c = surface.vertices[t[2]];
    const Vector3d twice = (b - a).cross(c - a);
    for (int k = 0; k < 3; ++k)
      if (std::abs(twice[k]) >= kSmallestArea) cost[k] += twice.norm() + 1;
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
  std::vector<std::unique_ptr<Cutter>> cutters(static_cast<std::size_t>(threadCount(threads)));
  std::atomic<std::size_t> done{0};
  parallelFor(count, threads, [&](std::size_t c, int worker) {
    if (bins.first[c] != bins.first[c + 1]) {
      std::unique_ptr<Cutter>& cutter = cutters[static_cast<std::size_t>(worker)];
      if (!cutter) cutter = std::make_unique<Cutter>(surface, frame);
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
