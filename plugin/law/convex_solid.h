// What contact needs of a convex solid: its farthest point, its core, and the feature that faces a
// direction.
#pragma once

#include <cloudcontact/law/solid.h>

#include <array>
#include <optional>

namespace cloudcontact {

// Whether the functions below know the solid: a half-space, ball, box, capsule, cylinder, a cone
// without a margin, or a hull of at most kMostFaces faces without a margin, whose frame's origin is
// inside and whose edges are known. Of a hull all corners are asked for each face.
bool isSimple(const Solid& solid);
constexpr std::size_t kMostFaces = 64;

// The point farthest along a direction of any length but 0; not of a half-space.
Vec3 supportOf(const Solid& solid, const Vec3& direction);

// How far it reaches along a unit vector from its center: that point along the direction.
double reachOf(const Solid& solid, const Vec3& direction);

// The solid less a skin: thinner by `skin` [m] on every face, but at least half as thick as the
// solid. All within the skin of the core is the solid with rounded edges, so the way from core to
// core is nearly that from solid to solid. A capsule's or ball's core is its segment or center (a
// capsule of radius 0), and the way exact. A hull's is the hull itself, scaled, so the way is exact
// where the same edges are the nearest. Not of a half-space.
struct PlacedCore {
  std::optional<Solid> solid;  // empty: the solid itself
  double scale = 1;            // of the solid about its frame's origin
  double sinks = 0;            // [m] its center, down the axis
};
PlacedCore coreOf(const Solid& solid, double skin);

// The part of a solid's surface that faces a direction.
struct Feature {
  // Corners of a face; a disc is a polygon. Of a hull's face with more, those that lie farthest
  // out.
  static constexpr int kMost = 16;
  enum class Kind { Point, Line, Face } kind = Kind::Point;
  int count = 0;
  std::array<Vec3, kMost> corners;  // of a face in order, counterclockwise seen from outside
  double radius = 0;                // of curvature across a line; of a disc [m]
};
// The face, line or point that looks most along `direction` (unit); not of a half-space.
Feature featureOf(const Solid& solid, const Vec3& direction);

}  // namespace cloudcontact
