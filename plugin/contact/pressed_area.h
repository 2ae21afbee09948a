// The area in which two features press on each other, and the points that stand for it.
#pragma once

#include <cloudcontact/contact/contact.h>

#include "law/convex_solid.h"

namespace cloudcontact {

// One body's feature about the contact, in coordinates (u, v) across the normal and h along it.
struct FlatFeature {
  enum class Kind {
    Point,
    Line,
    Face,
    Plane
  } kind = Kind::Plane;  // a plane is the face of a half-space
  int count = 0;
  std::array<Eigen::Vector2d, Feature::kMost> corners;
  std::array<double, Feature::kMost> heights;
  double radius = 0;  // of curvature across a line; of a disc that looks along the normal [m]
};

// Depths are linear over the area, as the faces are flat.
struct PressedArea {
  int points = 0;  // 1, 2 (along a line) or 4
  std::array<Eigen::Vector2d, 4> at;
  std::array<double, 4> middle;                        // h midway between the two surfaces
  std::array<double, 4> depth;                         // [m]; their mean is `whole`
  Eigen::Vector2d pressure = Eigen::Vector2d::Zero();  // center of pressure
  double pressureMiddle = 0;
  double whole = 0;  // the depth d of FR = k d (3) [m]
  double gap = 0;    // [m] by which the bodies were moved together; then all depths are less by it
  double area = 0;   // [m^2] 0 of a point or line
  double breadth = 0;  // [m] of the area in its narrow direction, or of the line along it
};

// Bodies that overlap by no more than `least`, or are apart by no more than `margin`, are moved
// together until they overlap by `touch` [m].
struct Nearing {
  double margin = 0, least = 0, touch = 0;
};

// `depth`: of the deepest point, for features of one point. Empty if the features do not meet.
std::optional<PressedArea> pressedArea(const FlatFeature& a, const FlatFeature& b, double depth,
                                       const Nearing& nearing);

}  // namespace cloudcontact
