// Where two shells pass through one column.
//
// The running sum of columns.cpp counts material once per enclosing shell. Where the surface of
// only one shell passes through a voxel, this does no harm: the other shells fill the voxel or miss
// it, and a sum above 1 is solid. Where two surfaces pass, the sum does not tell how much lies in
// both: two bodies that share a face at 0.3 of a voxel sum to 0.6, as do two separate ones of 0.3
// each. There 8x8 rays along the column estimate both the sum and the union. Where all rays find
// the voxel solid, or no overlap, the exact sum is kept; elsewhere it is multiplied by the ratio of
// union to sum. The error of the estimates cancels where surfaces coincide, the common case, and is
// at most some hundredths where they cross.
#include "voxels/overlap.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

using Eigen::Vector3d;

namespace {

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

}  // namespace

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

}  // namespace cloudcontact
