// Convex polygons, cut at whole numbers of one coordinate.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cloudcontact {

// A convex polygon. A triangle cut by at most six planes has at most nine corners; the room beyond
// is for slivers that rounding makes cross a plane more than twice, and what they have beyond that
// room has no area to lose.
struct Polygon {
  static constexpr int kMost = 16;
  int corners = 0;
  Eigen::Vector3d p[kMost];
  void add(const Eigen::Vector3d& x) {
    if (corners < kMost) p[corners++] = x;
  }
};

// The parts of `polygon` below and above the plane x[Axis] = value. Corners on the plane go to
// both, so that an area of zero may come out, never a gap.
template <int Axis>
void split(const Polygon& polygon, double value, Polygon& below, Polygon& above) {
  below.corners = above.corners = 0;
  const double first = polygon.p[0][Axis] - value;
  double da = first;
  for (int i = 0; i < polygon.corners; ++i) {
    const bool last = i + 1 == polygon.corners;
    const Eigen::Vector3d &a = polygon.p[i], &b = polygon.p[last ? 0 : i + 1];
    const double db = last ? first : b[Axis] - value;
    if (da <= 0) below.add(a);
    if (da >= 0) above.add(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
      Eigen::Vector3d x = a + (da / (da - db)) * (b - a);
      x[Axis] = value;
      below.add(x);
      above.add(x);
    }
    da = db;
  }
}

// Calls visit(cell, piece) for the pieces of `polygon` between whole numbers of x[Axis].
template <int Axis, typename Visit>
void slice(const Polygon& polygon, Visit&& visit) {
  double low = polygon.p[0][Axis], high = low;
  for (int i = 1; i < polygon.corners; ++i) {
    low = std::min(low, polygon.p[i][Axis]);
    high = std::max(high, polygon.p[i][Axis]);
  }
  const int first = static_cast<int>(std::floor(low));
  const int last = std::max(first, static_cast<int>(std::ceil(high)) - 1);
  if (first == last) return visit(first, polygon);
  Polygon buffers[2], piece;
  const Polygon* rest = &polygon;
  for (int cell = first; cell < last; ++cell) {
    Polygon& above = buffers[cell & 1];
    split<Axis>(*rest, cell + 1, piece, above);
    if (piece.corners > 2) visit(cell, piece);
    rest = &above;
  }
  if (rest->corners > 2) visit(last, *rest);
}

// Twice the projected area, positive where the triangle faces up.
inline double twiceProjectedArea(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                 const Eigen::Vector3d& c, int u, int v) {
  return (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
}

}  // namespace cloudcontact
