// Cuts one brick-wide column: see column_cutter.h, and columns.cpp for the method.
//
// Where two shells pass through one column. // The running sum of cutting counts material once per
// enclosing shell. Where the surface of only one shell passes through a voxel, this does no harm:
// the other shells fill the voxel or miss it, and a sum above 1 is solid. Where two surfaces pass,
// the sum does not tell how much lies in both: two bodies that share a face at 0.3 of a voxel sum
// to 0.6, as do two separate ones of 0.3 each. There 8x8 rays along the column estimate both the
// sum and the union. Where all rays find the voxel solid, or no overlap, the exact sum is kept;
// elsewhere it is multiplied by the ratio of union to sum. The error of the estimates cancels where
// surfaces coincide, the common case, and is at most some hundredths where they cross.
#include "voxels/column_cutter.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

using Eigen::Vector3d;
using Eigen::Vector3i;

namespace {

constexpr int kNoShell = -1, kSeveralShells = -2, kCap = -1;

// A voxel counts as capped above this projected area of caps [voxel^2].
constexpr double kCapArea = 1e-3;

// Adds the differences of one cell to the sums of all columns and computes their coverages.
void addCell(const double* differences, Runs& runs, std::uint8_t* coverage) {
  for (int c = 0; c < kColumnsPerBrick; ++c) {
    const double sum = runs.sum[c] + differences[c];
    runs.sum[c] = sum;
    runs.least[c] = std::min(runs.least[c], sum);
    runs.most[c] = std::max(runs.most[c], sum);
    coverage[c] = ccCoverage(sum);
  }
}

constexpr int kRays = 8;  // along each side of the column
// Offsets of the rays from regular positions, where edges of models often lie.
constexpr double kOffU = 0.5137, kOffV = 0.4871;

struct Crossing {
  double w;
  int step;  // change of the winding number, upward
};

// Where the line (u, v) crosses the triangle p, if it does.
bool crossing(const Vector3d* p, double u, double v, Crossing& found) {
  double side[3];
  for (int k = 0; k < 3; ++k) {
    const Vector3d &a = p[k], &b = p[(k + 1) % 3];
    side[k] = (b[0] - a[0]) * (v - a[1]) - (b[1] - a[1]) * (u - a[0]);
  }
  const bool up = side[0] > 0 && side[1] > 0 && side[2] > 0;
  const bool down = side[0] < 0 && side[1] < 0 && side[2] < 0;
  if (!up && !down) return false;
  const double total = side[0] + side[1] + side[2];
  found.w = (side[1] * p[0][2] + side[2] * p[1][2] + side[0] * p[2][2]) / total;
  found.step = up ? -1 : 1;  // material ends above a face that faces up
  return true;
}

// The crossings of a ray in ascending order; false where it slipped between two triangles.
bool castRay(const std::vector<Vector3d>& corners, double u, double v,
             std::vector<Crossing>& crossings) {
  crossings.clear();
  int end = 0;
  for (std::size_t t = 0; t + 2 < corners.size(); t += 3)
    if (Crossing found; crossing(&corners[t], u, v, found)) {
      crossings.push_back(found);
      end += found.step;
    }
  std::sort(crossings.begin(), crossings.end(),
            [](const Crossing& a, const Crossing& b) { return a.w < b.w; });
  return end == 0;
}

// Lengths per voxel of a column, stored as differences.
class Lengths {
 public:
  Lengths(int firstCell, std::size_t cells) : first_(firstCell), differences_(cells + 2, 0) {}
  // Adds `weight` per unit of length above w.
  void addAbove(double w, double weight) {
    const double cells = differences_.size() - 2;
    const double x = std::clamp(w - first_, 0.0, cells);
    const auto cell = static_cast<std::size_t>(x);
    const double part = x - static_cast<double>(cell);
    differences_[cell] += weight * (1 - part);
    differences_[cell + 1] += weight * part;
  }
  double next() { return run_ += differences_[at_++]; }

 private:
  int first_;
  std::vector<double> differences_;
  std::size_t at_ = 0;
  double run_ = 0;
};

// The coverage of a voxel from its exact sum, and from sum and union of the rays.
double united(double exactSum, double sum, double unite) {
  constexpr double kSame = 1e-9;
  if (unite > 1 - kSame || std::abs(sum - unite) < kSame) return exactSum;
  // With shells that face inward the sum may vanish, and the ratio is undefined.
  return sum > unite ? exactSum * (unite / sum) : exactSum + (unite - sum);
}

// Replaces the coverages of one column, each the sum over all shells, by those of the shells'
// union. `coverage[i]` belongs to cell firstCell + i of the third axis; `corners` are the
// triangles, three corners each, that may pass through the column's unit square at (u, v). All in
// voxels.
void uniteShells(const std::vector<Vector3d>& corners, double u, double v, int firstCell,
                 std::vector<double>& coverage) {
  Lengths sum(firstCell, coverage.size()), unite(firstCell, coverage.size());
  std::vector<Crossing> crossings;
  int rays = 0;
  for (int i = 0; i < kRays * kRays; ++i) {
    const double rayU = u + (i % kRays + kOffU) / kRays, rayV = v + (i / kRays + kOffV) / kRays;
    if (!castRay(corners, rayU, rayV, crossings)) continue;
    ++rays;
    int winding = 0;
    for (const Crossing& c : crossings) {
      const int now = winding + c.step;
      sum.addAbove(c.w, c.step);
      unite.addAbove(c.w, (now > 0) - (winding > 0));
      winding = now;
    }
  }
  const double weight = rays > 0 ? 1.0 / rays : 0;
  for (double& c : coverage) {
    const double s = weight * sum.next(), n = weight * unite.next();
    c = std::clamp(united(c, s, n), 0.0, 1.0);
  }
}

}  // namespace

ColumnCutter::ColumnCutter(const GridSurface& surface, const Frame& frame)
    : surface_(surface),
      frame_(frame),
      height_(frame.layers * kBrickEdge + 1),
      differences_(static_cast<std::size_t>(kColumnsPerBrick) * height_, 0.0),
      touched_(static_cast<std::size_t>(frame.layers) + 1, 0) {
  if (surface.firstCap < surface.triangles.size()) caps_.resize(differences_.size(), 0.0);
}

std::size_t ColumnCutter::bytes(int layers, bool capped) {
  return sizeof(double) * kColumnsPerBrick * (static_cast<std::size_t>(layers) * kBrickEdge + 1) *
         (capped ? 2 : 1);
}

BrickColumn ColumnCutter::cut(int bu, int bv, const int* first, const int* last) {
  lowest_ = height_, highest_ = -1;
  std::fill(std::begin(shell_), std::end(shell_), kNoShell);
  for (const int* t = first; t != last; ++t) cutTriangle(bu, bv, *t);
  BrickColumn result;
  if (highest_ < 0) return result;
  countCaps(result);
  overlapping_ = 0;
  for (int c = 0; c < kColumnsPerBrick; ++c)
    if (shell_[c] == kSeveralShells) overlapping_ |= std::uint64_t{1} << c;
  const std::uint64_t known = overlapping_;
  if (known) unite(bu, bv, first, last);
  sumUp(result);
  if (overlapping_ != known) {  // only the sums show a shell that overlaps itself
    overlapping_ &= ~known;
    unite(bu, bv, first, last);
    sumUp(result);
  }
  clear();
  return result;
}

void ColumnCutter::touch(int lowestCell, int highestCell) {
  for (int layer = lowestCell / kBrickEdge; layer <= highestCell / kBrickEdge; ++layer)
    touched_[layer] = 1;
}

void ColumnCutter::clear() {
  for (std::size_t layer = 0; layer < touched_.size(); ++layer) {
    if (!touched_[layer]) continue;
    const int first = static_cast<int>(layer) * kBrickEdge;
    std::fill(at(0, first), at(0, std::min(first + kBrickEdge, height_)), 0.0);
    touched_[layer] = 0;
  }
}

// A triangle in the frame of the brick column: its corner is the origin, and its axes are u, v, w.
CcPolygon ColumnCutter::inColumn(int bu, int bv, int triangle) const {
  CcPolygon polygon;
  polygon.corners = 0;
  for (int k = 0; k < 3; ++k) {
    const Vector3d& p = surface_.vertices[surface_.triangles[triangle][k]];
    addCorner(polygon, {p[frame_.u] - bu * kBrickEdge, p[frame_.v] - bv * kBrickEdge, p[frame_.w]});
  }
  return polygon;
}

void ColumnCutter::cutTriangle(int bu, int bv, int triangle) {
  const auto t = static_cast<std::size_t>(triangle);
  triangleShell_ = t >= surface_.firstCap       ? kCap
                   : surface_.component.empty() ? 0
                                                : surface_.component[t];
  CcPolygon whole = inColumn(bu, bv, triangle), spare, rest;
  CcPolygon* const inU = ccClip(&whole, 0, &spare, &rest);
  const CcPolygon* const polygon = ccClip(inU, 1, inU == &whole ? &spare : &whole, &rest);
  if (polygon->corners < 3) return;
  slice<1>(*polygon, [&](int v, const CcPolygon& row) {
    slice<0>(row, [&](int u, const CcPolygon& column) {
      const int c = std::min(u, kBrickEdge - 1) + kBrickEdge * std::min(v, kBrickEdge - 1);
      forEachPiece(column, [&](int w, const CcPiece& piece) { addPiece(c, w, piece); });
    });
  });
}

void ColumnCutter::addPiece(int column, int cell, const CcPiece& part) {
  double* d = at(column, cell);
  d[0] -= part.area - part.under;
  d[kColumnsPerBrick] -= part.under;
  touched_[cell / kBrickEdge] = 1;
  touched_[(cell + 1) / kBrickEdge] = 1;
  lowest_ = std::min(lowest_, cell);
  highest_ = std::max(highest_, cell);
  if (triangleShell_ == kCap)
    caps_[place(column, cell)] += std::abs(part.area);
  else if (shell_[column] != triangleShell_)
    shell_[column] = shell_[column] == kNoShell ? triangleShell_ : kSeveralShells;
}

void ColumnCutter::countCaps(BrickColumn& result) {
  if (caps_.empty()) return;
  for (int c = 0; c < kColumnsPerBrick; ++c) {
    int voxels = 0;
    for (int w = lowest_; w <= highest_; ++w) {
      double& area = caps_[place(c, w)];
      voxels += area > kCapArea;
      area = 0;
    }
    result.cappedVoxels += voxels;
    result.cappedColumns += voxels > 0;
  }
}

// The running sums, layer by layer of bricks, and the resulting bricks. Without a piece in a layer
// the sums do not change and the brick repeats: that holds for most layers of a body.
void ColumnCutter::sumUp(BrickColumn& result) {
  Runs runs;
  result.firstLayer = lowest_ / kBrickEdge;
  result.table.clear();
  result.coverage.clear();
  // The sums end one cell above the topmost piece.
  const int lastLayer = std::min(highest_ + 1, height_ - 2) / kBrickEdge;
  BrickCoverage brick;
  int code = 0;
  bool changed = true;
  for (int layer = result.firstLayer; layer <= lastLayer; ++layer) {
    const bool touched = touched_[layer] != 0;
    if (touched || changed) code = sumLayer(layer, runs, brick);
    changed = touched;
    result.table.push_back(code < 0 ? code : static_cast<std::int32_t>(result.coverage.size()));
    if (code >= 0) result.coverage.push_back(brick);
  }
  for (int c = 0; c < kColumnsPerBrick; ++c) {
    if (runs.most[c] > 1 + CC_CLOSED_SUM || runs.least[c] < -CC_CLOSED_SUM)
      overlapping_ |= std::uint64_t{1} << c;
    const double left = std::abs(runs.sum[c]);
    result.residue[c] = left > CC_CLOSED_SUM
                            ? static_cast<std::uint8_t>(std::min(255.0, std::ceil(255 * left)))
                            : std::uint8_t{0};
  }
}

// One layer of bricks: kEmptyBrick, kSolidBrick, or 0 where `brick` holds numbers.
int ColumnCutter::sumLayer(int layer, Runs& runs, BrickCoverage& brick) {
  BrickCoverage cells;  // in the order of differences_
  for (int w = 0; w < kBrickEdge; ++w)
    addCell(at(0, layer * kBrickEdge + w), runs, cells.data() + w * kColumnsPerBrick);
  return codeOf(cells, brick);
}

int ColumnCutter::codeOf(const BrickCoverage& cells, BrickCoverage& brick) const {
  std::uint8_t least = 255, most = 0;
  for (const std::uint8_t c : cells) least = std::min(least, c), most = std::max(most, c);
  if (most == 0) return kEmptyBrick;
  if (least == 255) return kSolidBrick;
  const int strideU = Frame::voxelStride(frame_.u), strideV = Frame::voxelStride(frame_.v),
            strideW = Frame::voxelStride(frame_.w);
  const std::uint8_t* cell = cells.data();
  for (int w = 0; w < kBrickEdge; ++w)
    for (int v = 0; v < kBrickEdge; ++v)
      for (int u = 0; u < kBrickEdge; ++u) brick[u * strideU + v * strideV + w * strideW] = *cell++;
  return 0;
}

// Replaces the differences of the overlapping columns, those of the sum over shells, by those of
// the shells' union.
void ColumnCutter::unite(int bu, int bv, const int* first, const int* last) {
  std::vector<Vector3d> corners;
  std::vector<double> coverage;
  for (int c = 0; c < kColumnsPerBrick; ++c) {
    if (!(overlapping_ >> c & 1)) continue;
    const int u = c % kBrickEdge, v = c / kBrickEdge;
    const int end = std::min(highest_ + 2, height_);
    double run = 0;
    coverage.clear();
    for (int w = lowest_; w < end; ++w) coverage.push_back(run += *at(c, w));
    if (std::abs(run) > CC_CLOSED_SUM) continue;  // the rays fail where the sum does not close
    corners.clear();
    for (const int* t = first; t != last; ++t) {
      const CcPolygon p = inColumn(bu, bv, *t);
      const CcSpan alongU = ccSpan(&p, 0), alongV = ccSpan(&p, 1);
      if (alongU.low < u + 1 && alongU.high > u && alongV.low < v + 1 && alongV.high > v)
        for (int k = 0; k < 3; ++k) corners.emplace_back(p.p[k]);
    }
    uniteShells(corners, u, v, lowest_, coverage);
    touch(lowest_, end - 1);
    double before = 0;
    for (int w = lowest_; w < end; ++w) {
      const double now = coverage[w - lowest_];
      *at(c, w) = now - before;
      before = now;
    }
  }
}

}  // namespace cloudcontact
