// A convex solid is an intersection of simpler ones, so its span is the intersection of theirs.
#include "law/solid_line.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cloudcontact {

namespace {

using Span = std::optional<LineSpan>;
constexpr double kEndless = std::numeric_limits<double>::infinity();
constexpr LineSpan kAll{-kEndless, kEndless};

Span both(const Span& a, const Span& b) {
  if (!a || !b) return {};
  const LineSpan span{std::max(a->from, b->from), std::min(a->to, b->to)};
  return span.from <= span.to ? Span(span) : Span();
}

// The least span that holds both.
Span around(const Span& a, const Span& b) {
  if (!a || !b) return a ? a : b;
  return LineSpan{std::min(a->from, b->from), std::max(a->to, b->to)};
}

// Where speed * t <= room.
Span below(double room, double speed) {
  if (speed == 0) return room >= 0 ? Span(kAll) : Span();
  return speed > 0 ? LineSpan{-kEndless, room / speed} : LineSpan{room / speed, kEndless};
}

// Where |x + speed * t| <= half.
Span slab(double x, double speed, double half) {
  return both(below(half - x, speed), below(half + x, -speed));
}

// Where a t^2 + 2 b t + c <= 0, for a >= 0.
Span parabola(double a, double b, double c) {
  if (!(a > 0)) return c <= 0 ? Span(kAll) : Span();
  const double root = b * b - a * c;
  if (root < 0) return {};
  return LineSpan{(-b - std::sqrt(root)) / a, (-b + std::sqrt(root)) / a};
}

struct Line {
  Vec3 at, way;
};

Span ball(const Line& line, double radius) {
  return parabola(line.way.squaredNorm(), line.at.dot(line.way),
                  line.at.squaredNorm() - radius * radius);
}

// A cylinder without ends, along z.
Span tube(const Line& line, double radius) {
  const auto x = line.at.head<2>(), d = line.way.head<2>();
  return parabola(d.squaredNorm() > 1e-24 ? d.squaredNorm() : 0, x.dot(d),
                  x.squaredNorm() - radius * radius);
}

// The half of a double cone about z that opens downward from the origin: r <= -slope * z.
Span nappe(const Line& line, double slope) {
  const auto x = line.at.head<2>(), d = line.way.head<2>();
  const double z = slope * line.at.z(), w = slope * line.way.z();
  const double a = d.squaredNorm() - w * w, b = x.dot(d) - z * w, c = x.squaredNorm() - z * z;
  const Span under = below(-z, w);
  if (a > 0) return both(parabola(a, b, c), under);
  // The line leaves through the opening: one end is at infinity.
  if (!(a < 0)) {
    if (b == 0) return c <= 0 ? under : Span();
    return both(below(-0.5 * c, b), under);
  }
  const double root = b * b - a * c;
  if (root <= 0) return under;
  const double first = (-b + std::sqrt(root)) / a, second = (-b - std::sqrt(root)) / a;
  return w > 0 ? LineSpan{-kEndless, std::min(first, second)}
               : LineSpan{std::max(first, second), kEndless};
}

Span spanOf(const HalfSpace& s, const Line& line) {
  return below(s.offset - s.normal.dot(line.at), s.normal.dot(line.way));
}
Span spanOf(const Sphere& s, const Line& line) {
  return ball(line, s.radius);
}
Span spanOf(const Box& s, const Line& line) {
  Span span = kAll;
  for (int k = 0; k < 3; ++k) span = both(span, slab(line.at[k], line.way[k], s.halfExtents[k]));
  return span;
}
Span spanOf(const Ellipsoid& s, const Line& line) {
  return ball({line.at.cwiseQuotient(s.semiAxes), line.way.cwiseQuotient(s.semiAxes)}, 1);
}
Span spanOf(const Cylinder& s, const Line& line) {
  return both(tube(line, s.radius), slab(line.at.z(), line.way.z(), s.halfHeight));
}
Span spanOf(const Capsule& s, const Line& line) {
  const Vec3 up(0, 0, s.halfHeight);
  return around(
      spanOf(Cylinder{s.radius, s.halfHeight}, line),
      around(ball({line.at - up, line.way}, s.radius), ball({line.at + up, line.way}, s.radius)));
}
Span spanOf(const Cone& s, const Line& line) {
  return both(nappe({line.at - Vec3(0, 0, s.halfHeight), line.way}, s.radius / (2 * s.halfHeight)),
              slab(line.at.z(), line.way.z(), s.halfHeight));
}
Span spanOf(const Hull& s, const Line& line) {
  Span span = kAll;
  for (const HalfSpace& plane : s.planes) span = both(span, spanOf(plane, line));
  return span;
}
Span spanOf(const CloudSolid&, const Line&) {
  return {};  // followed instead
}
Span spanOf(const SurfaceSolid&, const Line&) {
  return {};  // no area
}

// Whether the solid has no closed form.
bool isFollowed(const Solid& solid) {
  if (const auto* cone = std::get_if<Cone>(&solid)) return cone->margin > 0;
  if (const auto* hull = std::get_if<Hull>(&solid)) return hull->margin > 0;
  return std::holds_alternative<CloudSolid>(solid);
}

// Where the line leaves, between two points inside and outside.
double leaves(const PlacedSolid& area, const Line& line, double low, double high, double under,
              double above, double tolerance) {
  for (int k = 0; k < 4; ++k) {
    const double mid = low + (high - low) * under / (under - above);
    const double at = depthOf(area, line.at + mid * line.way);
    if (std::abs(at) < tolerance) return mid;
    (at >= 0 ? low : high) = mid;
    (at >= 0 ? under : above) = at;
  }
  return low + (high - low) * under / (under - above);
}

Span follow(const PlacedSolid& area, const Line& line, double step) {
  // Outside, the way in is at least the distance.
  double in = 0, depth = depthOf(area, line.at), outside = 0, beyond = depth;
  if (!(depth >= 0)) {
    const double most = boundsOf(area).sizes().norm() - depth;
    while (!(depth >= 0)) {
      outside = in, beyond = depth;
      in += std::max(-depth, 0.25 * step);
      if (!(in <= most)) return {};
      depth = depthOf(area, line.at + in * line.way);
    }
  }
  const double from = in == 0 ? 0 : in - (in - outside) * depth / (depth - beyond);
  for (;;) {
    const double out = in + std::max(depth, step), there = depthOf(area, line.at + out * line.way);
    if (!(there >= 0))
      return LineSpan{from, leaves(area, line, in, out, depth, there, 1e-3 * step)};
    in = out, depth = there;
  }
}

using Farthest = std::optional<Vec3>;

// A disk's about z.
Vec3 onRim(double radius, const Vec3& way) {
  const double across = way.head<2>().norm();
  return across > 0 ? Vec3(radius / across * way.x(), radius / across * way.y(), 0) : Vec3::Zero();
}
double side(double x) {
  return x < 0 ? -1 : 1;
}

Farthest farthest(const HalfSpace&, const Vec3&) {
  return {};
}
Farthest farthest(const CloudSolid&, const Vec3&) {
  return {};
}
Farthest farthest(const SurfaceSolid&, const Vec3&) {
  return {};
}
Farthest farthest(const Sphere& s, const Vec3& way) {
  return s.radius * way;
}
Farthest farthest(const Box& s, const Vec3& way) {
  return Vec3(s.halfExtents.cwiseProduct(way.unaryExpr(&side)));
}
Farthest farthest(const Ellipsoid& s, const Vec3& way) {
  const Vec3 scaled = s.semiAxes.cwiseProduct(way);
  return Vec3(s.semiAxes.cwiseProduct(scaled) / scaled.norm());
}
Farthest farthest(const Cylinder& s, const Vec3& way) {
  return onRim(s.radius, way) + Vec3(0, 0, s.halfHeight * side(way.z()));
}
Farthest farthest(const Capsule& s, const Vec3& way) {
  return s.radius * way + Vec3(0, 0, s.halfHeight * side(way.z()));
}
Farthest farthest(const Cone& s, const Vec3& way) {
  const Vec3 tip(0, 0, s.halfHeight), base = onRim(s.radius, way) - tip;
  return (tip.dot(way) > base.dot(way) ? tip : base) + s.margin * way;
}
Farthest farthest(const Hull& s, const Vec3& way) {
  Farthest most;
  for (const Vec3& corner : s.corners)
    if (!most || corner.dot(way) > most->dot(way)) most = corner;
  if (most) *most += s.margin * way;
  return most;
}

}  // namespace

SolidLines::SolidLines(const PlacedSolid& area, const Vec3& way, double step)
    : area_(&area),
      way_(way),
      toLocal_(area.place.orientation.toRotationMatrix().transpose()),
      step_(step),
      followed_(isFollowed(area.solid)) {
  localWay_ = toLocal_ * way;
}

std::optional<LineSpan> SolidLines::through(const Vec3& point) const {
  if (followed_) return follow(*area_, {point, way_}, step_);
  const Line line{toLocal_ * (point - area_->place.position), localWay_};
  return std::visit([&](const auto& kind) { return spanOf(kind, line); }, area_->solid);
}

std::optional<Vec3> farthestOf(const PlacedSolid& area, const Vec3& way) {
  const Vec3 local = area.place.orientation.conjugate() * way;
  const Farthest most =
      std::visit([&](const auto& kind) { return farthest(kind, local); }, area.solid);
  return most ? Farthest(area.place.toWorld(*most)) : most;
}

}  // namespace cloudcontact
