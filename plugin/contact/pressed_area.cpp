// The points are those of docs/force.md, "Points", for an area whose depth t is linear: with x the
// area's center, C its covariance and t' the mean of t, they are x + root(C) (+-1, +-1) with depths
// d t / t'. Their force and moment are those of t over the area, if all of it is d deep.
#include "contact/pressed_area.h"

#include <algorithm>
#include <cmath>

#include "kernels/contact/contact_depth.h"

namespace cloudcontact {

namespace {

using Vec2 = Eigen::Vector2d;
using Kind = FlatFeature::Kind;

constexpr double kLeast = 0.05;  // of the mean, a point's depth at least: no point pulls
constexpr double kSmallSine = 1e-4;
constexpr double kRound = 1.01;  // of a disc's radius: its polygon's sides are off by twice as much

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// A linear function of (u, v).
struct Slope {
  double at0 = 0;
  Vec2 by = Vec2::Zero();
  double at(const Vec2& x) const { return at0 + by.dot(x); }
};

Slope heightOf(const FlatFeature& face) {
  if (face.kind == Kind::Plane) return {face.heights[0], Vec2::Zero()};
  const std::size_t i = static_cast<std::size_t>(face.count) / 3;
  const std::size_t j = static_cast<std::size_t>(face.count) * 2 / 3;
  const Vec2 u = face.corners[i] - face.corners[0], v = face.corners[j] - face.corners[0];
  const double du = face.heights[i] - face.heights[0], dv = face.heights[j] - face.heights[0];
  const double whole = cross(u, v);
  Slope s;
  if (whole != 0) s.by = Vec2(du * v.y() - dv * u.y(), dv * u.x() - du * v.x()) / whole;
  s.at0 = face.heights[0] - s.by.dot(face.corners[0]);
  return s;
}

struct Polygon {
  int count = 0;
  std::array<Vec2, 2 * Feature::kMost + 2> corners;

  // Keeps what is at a positive `value`.
  template <typename Value>
  void clip(const Value& value) {
    std::array<double, 2 * Feature::kMost + 2> values;
    bool cut = false;
    for (int i = 0; i < count; ++i) cut |= (values[i] = value(corners[i])) < 0;
    if (!cut) return;
    Polygon kept;
    for (int i = 0; i < count; ++i) {
      const int next = i + 1 < count ? i + 1 : 0;
      const Vec2 &a = corners[i], &b = corners[next];
      const double va = values[i], vb = values[next];
      if (va >= 0) kept.corners[kept.count++] = a;
      if ((va < 0) != (vb < 0)) kept.corners[kept.count++] = a + va / (va - vb) * (b - a);
      if (kept.count + 2 > static_cast<int>(corners.size())) break;
    }
    count = kept.count;
    std::copy_n(kept.corners.begin(), count, corners.begin());
  }
};

// +1 if the corners run counterclockwise.
double senseOf(const FlatFeature& face) {
  double twice = 0;
  for (int i = 0; i < face.count; ++i)
    twice += cross(face.corners[i], face.corners[i + 1 < face.count ? i + 1 : 0]);
  return twice < 0 ? -1 : 1;
}

// How far inside the i-th side of a face a point is, times the side's length.
double inside(const FlatFeature& face, double sense, int i, const Vec2& x) {
  const Vec2& a = face.corners[i];
  const Vec2& b = face.corners[i + 1 < face.count ? i + 1 : 0];
  return sense * cross(b - a, x - a);
}

// Whether all of a face lies in a disc that looks along the normal, which is a circle and reaches
// beyond the sides of its polygon.
bool isInDisc(const FlatFeature& face, const FlatFeature& disc) {
  if (!(disc.radius > 0)) return false;
  const Vec2 middle = (disc.corners[0] + disc.corners[disc.count / 2]) / 2;
  const double most = disc.radius * disc.radius * kRound * kRound;
  for (int i = 0; i < face.count; ++i)
    if ((face.corners[i] - middle).squaredNorm() > most) return false;
  return true;
}

// The common part of two faces. The face with fewer sides cuts the other.
Polygon common(const FlatFeature& a, const FlatFeature& b) {
  const bool cutsA =
      b.kind == Kind::Plane ||
      (a.kind != Kind::Plane && (b.count < a.count || (b.count == a.count && b.radius > a.radius)));
  const FlatFeature &first = cutsA ? a : b, &second = cutsA ? b : a;
  Polygon p;
  p.count = first.count;
  std::copy_n(first.corners.begin(), first.count, p.corners.begin());
  if (second.kind == Kind::Plane || isInDisc(first, second)) return p;
  const double sense = senseOf(second);
  for (int i = 0; i < second.count && p.count > 0; ++i)
    p.clip([&](const Vec2& x) { return inside(second, sense, i, x); });
  return p;
}

// Moves the bodies together if they are apart. False if they are too far apart.
bool close(double most, const Nearing& near, PressedArea& out) {
  if (most > near.least) return true;
  if (-most > near.margin) return false;
  out.gap = near.touch - most;
  return true;
}

// Integrals over a polygon, in coordinates about its first corner.
struct AreaSums {
  double area = 0;
  Vec2 first = Vec2::Zero();
  double uu = 0, uv = 0, vv = 0;
  double depth[3] = {};  // of t^k
  Vec2 pressed = Vec2::Zero();
};

AreaSums sumsOf(const Polygon& p, const Slope& t) {
  AreaSums s;
  const Vec2 o = p.corners[0];
  const double t0 = t.at(o);
  for (int i = 1; i + 1 < p.count; ++i) {
    const Vec2 a = p.corners[i] - o, b = p.corners[i + 1] - o, sum = a + b;
    const double area = 0.5 * std::abs(cross(a, b)), ta = t0 + t.by.dot(a), tb = t0 + t.by.dot(b);
    s.area += area;
    s.first += area / 3 * sum;
    s.uu += area / 12 * (sum.x() * sum.x() + a.x() * a.x() + b.x() * b.x());
    s.vv += area / 12 * (sum.y() * sum.y() + a.y() * a.y() + b.y() * b.y());
    s.uv += area / 12 * (sum.x() * sum.y() + a.x() * a.y() + b.x() * b.y());
    // Complete homogeneous polynomials of the corners' depths.
    const double h1 = t0 + ta + tb, e2 = t0 * ta + t0 * tb + ta * tb, e3 = t0 * ta * tb;
    const double h2 = h1 * h1 - e2, h3 = h1 * h2 - e2 * h1 + e3;
    s.depth[0] += area / 3 * h1;
    s.depth[1] += area / 6 * h2;
    s.depth[2] += area / 10 * h3;
    s.pressed += area / 12 * (h1 * sum + ta * a + tb * b);
  }
  return s;
}

// Sets the points' depths, with a mean of d. Where one of them would pull, the depths are more even
// and the points nearer to the center of pressure. `center`: of the area.
void setDepths(double d, double mean, const Slope& t, const Vec2& center, PressedArea& out) {
  double lowest = mean;
  for (int i = 0; i < 4; ++i) lowest = std::min(lowest, t.at(out.at[i]));
  const double most = mean - lowest;
  const double less = most > (1 - kLeast) * mean ? (1 - kLeast) * mean / most : 1;
  for (int i = 0; i < 4; ++i) {
    out.depth[i] = d * (1 + less * (t.at(out.at[i]) - mean) / mean);
    out.at[i] += (1 - less) * (out.pressure - center);
  }
}

std::optional<PressedArea> onFaces(const FlatFeature& a, const FlatFeature& b,
                                   const Nearing& nearing) {
  const Slope top = heightOf(a), bottom = heightOf(b);
  Slope t{top.at0 - bottom.at0, top.by - bottom.by};
  Polygon p = common(a, b);
  double most = -1e300;
  for (int i = 0; i < p.count; ++i) most = std::max(most, t.at(p.corners[i]));
  PressedArea out;
  if (p.count < 3 || !close(most, nearing, out)) return std::nullopt;
  t.at0 += out.gap;
  p.clip([&](const Vec2& x) { return t.at(x); });
  if (p.count < 3) return std::nullopt;
  const AreaSums s = sumsOf(p, t);
  if (!(s.depth[0] > 0)) return std::nullopt;
  const Vec2 c = s.first / s.area, x = p.corners[0] + c;
  const CcSymmetric2 root =
      ccMatrixRoot({s.uu / s.area - c.x() * c.x(), s.uv / s.area - c.x() * c.y(),
                    s.vv / s.area - c.y() * c.y()});
  const Vec2 corner[2] = {{root.uu + root.uv, root.uv + root.vv},
                          {root.uv - root.uu, root.vv - root.uv}};
  out.points = 4;
  for (int i = 0; i < 4; ++i) out.at[i] = i < 2 ? Vec2(x + corner[i & 1]) : Vec2(x - corner[i & 1]);
  out.whole = std::min(ccDeepestByMoments(s.depth), most + out.gap);
  out.pressure = p.corners[0] + s.pressed / s.depth[0];
  setDepths(out.whole, s.depth[0] / s.area, t, x, out);
  const auto middle = [&](const Vec2& at) { return (top.at(at) + bottom.at(at)) / 2; };
  for (int i = 0; i < 4; ++i) out.middle[i] = middle(out.at[i]);
  out.pressureMiddle = middle(out.pressure);
  out.area = s.area;
  // A symmetric matrix's smaller eigenvalue; a strip b wide has a deviation of b / root(12).
  const double half = (root.uu - root.vv) / 2;
  out.breadth =
      std::sqrt(12.0) * ((root.uu + root.vv) / 2 - std::sqrt(half * half + root.uv * root.uv));
  return out;
}

// A stretch of a line, by its parameter from 0 to 1.
struct Stretch {
  double from = 0, to = 1;
  void limit(double v0, double v1) {  // to where a linear value, v0 at 0 and v1 at 1, is positive
    const double slope = v1 - v0;
    if (slope == 0) {
      if (v0 < 0) to = from - 1;
      return;
    }
    const double at = -v0 / slope;
    (slope > 0 ? from : to) = slope > 0 ? std::max(from, at) : std::min(to, at);
  }
};

// The line's height above the other feature, or its own, at both ends.
struct Ends {
  double own[2], other[2];
};

std::optional<PressedArea> onLine(const FlatFeature& line, Stretch stretch, const Ends& ends,
                                  double sign, const Nearing& nearing) {
  if (!(stretch.from <= stretch.to)) return std::nullopt;
  const auto along = [](const double* v, double s) { return v[0] + s * (v[1] - v[0]); };
  double t[2] = {sign * (ends.own[0] - ends.other[0]), sign * (ends.own[1] - ends.other[1])};
  PressedArea out;
  const double most = std::max(along(t, stretch.from), along(t, stretch.to));
  if (!close(most, nearing, out)) return std::nullopt;
  for (double& depth : t) depth += out.gap;
  stretch.limit(t[0], t[1]);
  const double t0 = along(t, stretch.from), t1 = along(t, stretch.to);
  const double mean = (t0 + t1) / 2, center = (stretch.from + stretch.to) / 2;
  if (!(stretch.from <= stretch.to) || !(mean > 0)) return std::nullopt;
  const double half = (stretch.to - stretch.from) / 2, off = half / std::sqrt(3.0);
  const double powers[3] = {mean, (t0 * t0 + t0 * t1 + t1 * t1) / 3,
                            (t0 + t1) * (t0 * t0 + t1 * t1) / 4};
  out.whole = std::min(ccDeepestByMoments(powers), most + out.gap);
  out.points = half > 0 ? 2 : 1;
  const Vec2 way = line.corners[1] - line.corners[0];
  out.breadth = 2 * half * way.norm();
  const auto place = [&](double s) { return Vec2(line.corners[0] + s * way); };
  const auto middle = [&](double s) { return (along(ends.own, s) + along(ends.other, s)) / 2; };
  const double pressed = center + (t1 - t0) / 2 / mean * half / 3;
  // The depth's slope over its mean, at a point; kLeast as above.
  const double steep = (t1 - t0) / 2 / std::sqrt(3.0) / mean;
  const double lean = std::clamp(steep, kLeast - 1, 1 - kLeast);
  const double shifted = steep == lean ? center : pressed - lean * off;
  for (int i = 0; i < out.points; ++i) {
    const double side = out.points == 1 ? 0 : 2 * i - 1, s = shifted + side * off;
    out.at[i] = place(s);
    out.middle[i] = middle(s);
    out.depth[i] = out.whole * (1 + side * lean);
  }
  out.pressure = place(pressed);
  out.pressureMiddle = middle(pressed);
  return out;
}

std::optional<PressedArea> lineOnFace(const FlatFeature& line, const FlatFeature& face, double sign,
                                      const Nearing& nearing) {
  Stretch stretch;
  if (face.kind == Kind::Face) {
    const double sense = senseOf(face);
    for (int i = 0; i < face.count; ++i)
      stretch.limit(inside(face, sense, i, line.corners[0]),
                    inside(face, sense, i, line.corners[1]));
  }
  const Slope height = heightOf(face);
  const Ends ends{{line.heights[0], line.heights[1]},
                  {height.at(line.corners[0]), height.at(line.corners[1])}};
  return onLine(line, stretch, ends, sign, nearing);
}

// Lines across each other touch near their crossing, as far along as their curvature lets them.
std::optional<PressedArea> lineOnLine(const FlatFeature& a, const FlatFeature& b, double depth,
                                      const Nearing& nearing) {
  const Vec2 wayA = a.corners[1] - a.corners[0], wayB = b.corners[1] - b.corners[0];
  const double lengthA = wayA.norm(), lengthB = wayB.norm();
  if (!(lengthA > 0) || !(lengthB > 0)) return std::nullopt;
  const Vec2 from = b.corners[0] - a.corners[0];
  const double sine = cross(wayA, wayB) / (lengthA * lengthB);
  // B's ends seen along A, as parameters of A.
  const double s0 = from.dot(wayA) / (lengthA * lengthA);
  const double s1 = s0 + wayB.dot(wayA) / (lengthA * lengthA);
  Ends ends{{a.heights[0], a.heights[1]}, {}};
  Stretch stretch{std::max(0.0, std::min(s0, s1)), std::min(1.0, std::max(s0, s1))};
  const double slopeB = std::abs(s1 - s0) > 1e-9 ? (b.heights[1] - b.heights[0]) / (s1 - s0) : 0;
  ends.other[0] = b.heights[0] - s0 * slopeB;
  ends.other[1] = ends.other[0] + slopeB;
  if (std::abs(sine) > kSmallSine) {
    const double middle = std::clamp(cross(from, wayB) / cross(wayA, wayB), 0.0, 1.0);
    const double round = a.radius * b.radius / (a.radius + b.radius);
    const double far =
        std::sqrt(2 * round * std::max(depth, nearing.touch)) / (std::abs(sine) * lengthA);
    if (stretch.from > stretch.to) return std::nullopt;
    const double near = std::clamp(middle, stretch.from, stretch.to);
    stretch = {std::max(stretch.from, near - far), std::min(stretch.to, near + far)};
    // Both lie across the normal there, so the depth is even.
    ends.own[0] = ends.own[1] = a.heights[0] + near * (a.heights[1] - a.heights[0]);
    ends.other[0] = ends.other[1] = ends.own[0] - depth;
  }
  return onLine(a, stretch, ends, 1, nearing);
}

// One point of a body that is round there: it touches where its deepest point is.
std::optional<PressedArea> onPoint(const FlatFeature& point, double sign, double depth,
                                   const Nearing& nearing) {
  PressedArea out;
  if (!close(depth, nearing, out)) return std::nullopt;
  out.points = 1;
  out.at[0] = out.pressure = point.corners[0];
  out.middle[0] = out.pressureMiddle = point.heights[0] - sign * depth / 2;
  out.depth[0] = out.whole = depth + out.gap;
  return out;
}

}  // namespace

std::optional<PressedArea> pressedArea(const FlatFeature& a, const FlatFeature& b, double depth,
                                       const Nearing& nearing) {
  if (a.kind == Kind::Point) return onPoint(a, 1, depth, nearing);
  if (b.kind == Kind::Point) return onPoint(b, -1, depth, nearing);
  if (a.kind == Kind::Line && b.kind == Kind::Line) return lineOnLine(a, b, depth, nearing);
  if (a.kind == Kind::Line) return lineOnFace(a, b, 1, nearing);
  if (b.kind == Kind::Line) return lineOnFace(b, a, -1, nearing);
  return onFaces(a, b, nearing);
}

}  // namespace cloudcontact
