// A direction, the two features that face along it, and the area in which they press.
#include "contact/shape_contact.h"

#include <algorithm>

#include "contact/contact_builder.h"
#include "contact/press_direction.h"
#include "contact/pressed_area.h"

namespace cloudcontact {

namespace {

constexpr double kSameCircle = 0.9999;  // cosine: a circle tilted by less is a circle to 0.01 %
constexpr double kTouch = 0.1;  // [voxels] overlap of bodies that are moved together, as in clouds

// Two directions across the normal that turn with body A, so that points keep their places.
Eigen::Matrix3d axesAbout(const Vec3& normal, const Eigen::Matrix3d& turnA) {
  const Vec3 local = turnA.transpose() * normal;
  int most;
  local.cwiseAbs().maxCoeff(&most);
  const Vec3 other = turnA.col((most + 1) % 3);
  Eigen::Matrix3d axes;
  axes.col(2) = normal;
  axes.col(0) = (other - other.dot(normal) * normal).normalized();
  axes.col(1) = normal.cross(axes.col(0));
  return axes;
}

// `outward`: of the body, along the contact's normal or against it.
FlatFeature flatFeature(const PlacedConvex& body, const Vec3& outward, const Eigen::Matrix3d& axes,
                        const Vec3& origin) {
  FlatFeature flat;
  if (const auto* half = std::get_if<HalfSpace>(body.solid)) {
    const Vec3 n = body.turn * half->normal;
    const double above = half->offset + n.dot(body.at - origin);
    flat.heights[0] = n.dot(axes.col(2)) < 0 ? -above : above;
    return flat;
  }
  const Feature feature = featureOf(*body.solid, body.turn.transpose() * outward);
  flat.kind = static_cast<FlatFeature::Kind>(feature.kind);
  flat.count = feature.count;
  flat.radius = feature.radius;
  // A tilted disc is none, seen along the normal.
  if (feature.kind == Feature::Kind::Face &&
      std::abs(axes.col(2).dot(body.turn.col(2))) < kSameCircle)
    flat.radius = 0;
  const Eigen::Matrix3d turn = axes.transpose() * body.turn;
  const Vec3 at = axes.transpose() * (body.at - origin);
  for (int i = 0; i < feature.count; ++i) {
    const Vec3 x = turn * feature.corners[i] + at;
    flat.corners[i] = x.head<2>();
    flat.heights[i] = x.z();
  }
  return flat;
}

struct ShapePair {
  const ContactBody &a, &b;
  const ContactSettings& settings;
  Nearing nearing;
  PlacedConvex inA, inB;  // about A's position
};

// A point near the contact, about which coordinates are small.
Vec3 originOf(const PlacedConvex& a, const PlacedConvex& b, const Vec3& n) {
  return std::holds_alternative<HalfSpace>(*b.solid) ? a.support(n) : b.support(-n);
}

void addArea(const PressedArea& area, const ShapePair& pair, const Eigen::Matrix3d& axes,
             const Vec3& origin, ContactResult& found) {
  const ContactBody &a = pair.a, &b = pair.b;
  const KelvinVoigt spring =
      a.tissues || b.tissues ? springOf({}, a, b) : sharedSpring(pair.settings.law);
  const auto world = [&](const Eigen::Vector2d& at, double height) {
    return Vec3(a.pose.position + origin + axes * Vec3(at.x(), at.y(), height));
  };
  Patch& patch = found.patches.emplace_back();
  patch.position = world(area.pressure, area.pressureMiddle);
  patch.normal = axes.col(2);
  patch.depth = area.whole - area.gap;
  patch.stiffness = spring.stiffness;
  patch.damping = spring.damping;
  patch.area = area.area;
  patch.points = area.points;
  for (int i = 0; i < area.points; ++i) {
    ContactPoint& point = found.points.emplace_back();
    point.position = world(area.at[i], area.middle[i]);
    point.normal = patch.normal;
    point.depth = area.depth[i] - area.gap;
    point.stiffness = point.slope = spring.stiffness / area.points;
    point.damping = spring.damping / area.points;
  }
}

// The points of a contact along a direction, if the features that face it meet. `mustBeBroad`: in
// an area broader than the bodies are deep in each other, so that no way out aside is shorter.
bool tryAlong(const ShapePair& pair, const PressDirection& press, bool mustBeBroad,
              ContactResult& found) {
  const Vec3& n = press.normal;
  const Vec3 origin = originOf(pair.inA, pair.inB, n);
  const Eigen::Matrix3d axes = axesAbout(n, pair.inA.turn);
  const FlatFeature ofA = flatFeature(pair.inA, n, axes, origin);
  const FlatFeature ofB = flatFeature(pair.inB, -n, axes, origin);
  const auto area = pressedArea(ofA, ofB, press.depth, pair.nearing);
  if (!area || (mustBeBroad && press.depth > area->breadth)) return false;
  addArea(*area, pair, axes, origin, found);
  return true;
}

}  // namespace

bool takesShapes(const Solid& a, const Solid& b, const ContactSettings& settings) {
  const bool halves = std::holds_alternative<HalfSpace>(a) && std::holds_alternative<HalfSpace>(b);
  return isSimple(a) && isSimple(b) && !halves && !std::holds_alternative<Foundation>(settings.law);
}

bool findShapes(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
                double voxel, ContactResult& found, bool meetsLightly) {
  found.clear();
  const double margin = std::max(0.0, settings.margin), touch = kTouch * voxel;
  const ShapePair pair{
      a,
      b,
      settings,
      {margin, meetsLightly ? touch : 0, touch},
      {a.shape, a.pose.orientation.toRotationMatrix(), Vec3::Zero()},
      {b.shape, b.pose.orientation.toRotationMatrix(), b.pose.position - a.pose.position}};
  if (!isClosedForm(*a.shape, *b.shape))
    if (const auto face = faceDirection(pair.inA, pair.inB)) {
      if (face->depth < -margin) return true;
      if (tryAlong(pair, *face, true, found)) return true;
    }
  const auto press = pressDirection(pair.inA, pair.inB);
  if (!press) return false;
  if (press->depth < -margin) return true;
  return tryAlong(pair, *press, false, found) || press->depth <= 0;
}

void giveIds(const ContactBody& a, double voxel, PatchIds& ids, ContactResult& found) {
  const Eigen::Matrix3d turn = a.pose.orientation.toRotationMatrix();
  ids.begin();
  for (const Patch& patch : found.patches)
    ids.add(turn.transpose() * (patch.position - a.pose.position), turn.transpose() * patch.normal);
  ids.give(found, voxel);
}

}  // namespace cloudcontact
