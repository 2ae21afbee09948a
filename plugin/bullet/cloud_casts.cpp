// Rays through the field; sweeps by Bullet's own cast onto single triangles, or onto the shape that
// the cloud is.
#include "bullet/cloud_casts.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/NarrowPhaseCollision/btContinuousConvexCollision.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include <algorithm>

#include "bullet/convert.h"
#include "field/closed_form.h"
#include "field/field_ray.h"
#include "field/smoothed_point.h"
#include "field/surface_tree.h"

namespace cloudcontact {

namespace {

constexpr double kCastDistance = 1e-3;  // [m] Bullet's cast ends this near to the surface
constexpr double kNoGain = 0.02;        // [voxels] hits that precede the first by less
// Cosines: a cast's normal that is as near to the field's is the field's, beside edges and on
// faces. Bullet's cast is up to 30 deg off in float.
constexpr double kBesideEdge = 0.966, kOnFace = 0.5;
constexpr double kTurns = 1e-6;  // difference of two rotation matrices

// The hit of Bullet's cast onto a convex shape at `place`, if it is before `limit`.
std::optional<btConvexCast::CastResult> castOnto(const btConvexShape& shape,
                                                 const btTransform& place,
                                                 const btTriangleConvexcastCallback& sweep,
                                                 double limit) {
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver depths;
  btContinuousConvexCollision cast(sweep.m_convexShape, &shape, &simplex, &depths);
  btConvexCast::CastResult hit;
  hit.m_fraction = 1;
  hit.m_allowedPenetration = sweep.m_allowedPenetration;
  if (!cast.calcTimeOfImpact(sweep.m_convexShapeFrom, sweep.m_convexShapeTo, place, place, hit) ||
      !(hit.m_normal.length2() > btScalar(0.0001)) || !(hit.m_fraction < limit))
    return std::nullopt;
  return hit;
}

// Bullet's shape of a solid, without memory of its own.
class ConvexForm {
 public:
  explicit ConvexForm(const Solid& solid) {
    std::visit([this](const auto& s) { make(s); }, solid);
  }
  const btConvexShape& operator*() const {
    return *std::visit(
        [](const auto& shape) -> const btConvexShape* {
          if constexpr (std::is_same_v<decltype(shape), const std::monostate&>)
            return nullptr;
          else
            return &shape;
        },
        shape_);
  }

 private:
  static btVector3 boxOf(double x, double y, double z) {
    return {btScalar(x), btScalar(y), btScalar(z)};
  }
  void make(const Sphere& s) { shape_.emplace<btSphereShape>(btScalar(s.radius)); }
  void make(const Box& b) { shape_.emplace<btBoxShape>(toBullet(b.halfExtents)); }
  void make(const Cylinder& c) {
    shape_.emplace<btCylinderShapeZ>(boxOf(c.radius, c.radius, c.halfHeight));
  }
  void make(const Capsule& c) {
    shape_.emplace<btCapsuleShapeZ>(btScalar(c.radius), btScalar(2 * c.halfHeight));
  }
  void make(const Cone& c) {
    shape_.emplace<btConeShapeZ>(btScalar(c.radius), btScalar(2 * c.halfHeight));
  }
  void make(const Hull& h) {
    btConvexHullShape& hull = shape_.emplace<btConvexHullShape>();
    for (const Vec3& corner : h.corners) hull.addPoint(toBullet(corner), false);
    hull.setMargin(0);
    hull.recalcLocalAabb();
  }
  template <typename Other>
  void make(const Other&) {}  // no closed form is one

  std::variant<std::monostate, btSphereShape, btBoxShape, btCylinderShapeZ, btCapsuleShapeZ,
               btConeShapeZ, btConvexHullShape>
      shape_;
};

class ConvexSweep {
 public:
  ConvexSweep(const SurfaceField& field, int index, btTriangleConvexcastCallback& sweep)
      : field_(field), index_(index), sweep_(sweep), limit_(sweep.m_hitFraction) {
    const btTransform toLocal = sweep.m_triangleToWorld.inverse();
    const btTransform from = toLocal * sweep.m_convexShapeFrom,
                      to = toLocal * sweep.m_convexShapeTo;
    toConvex_ = from.getBasis().transpose();
    start_ = toVec3(from.getOrigin());
    motion_ = toVec3(to.getOrigin()) - start_;
    for (int row = 0; row < 3; ++row)
      turns_ |= (from.getBasis()[row] - to.getBasis()[row]).length() > kTurns;
    slack_ = kCastDistance + sweep.m_triangleCollisionMargin + sweep.m_allowedPenetration;
    btVector3 low, high;
    sweep.m_convexShape->getAabb(btTransform(from.getBasis()), low, high);
    Vec3 least = toVec3(low), most = toVec3(high);
    if (turns_) {
      most.setConstant(sweep.m_convexShape->getAngularMotionDisc());
      least = -most;
    }
    box_ = {Vec3(start_ + least - Vec3::Constant(slack_)),
            Vec3(start_ + most + Vec3::Constant(slack_))};
    const double length = motion_.norm();
    gain_ = length > 0 ? kNoGain * field.cloud().voxelSize() / length : 0;
  }

  void run() {
    const SurfaceTree& tree = surfaceTree(field_);
    tree.search([this](const Eigen::AlignedBox3d& box) { return entry(box); }, limit_,
                [&](std::uint32_t triangle) { meet(tree.corners(triangle)); });
  }

 private:
  // The fraction at which the convex shape's box reaches another; more than any fraction if never.
  double entry(const Eigen::AlignedBox3d& box) const {
    constexpr double kNever = 2;
    double enter = 0, leave = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const double ahead = box.min()[axis] - box_.max()[axis];
      const double behind = box.max()[axis] - box_.min()[axis], speed = motion_[axis];
      if (speed == 0) {
        if (ahead > 0 || behind < 0) return kNever;
        continue;
      }
      enter = std::max(enter, (speed > 0 ? ahead : behind) / speed);
      leave = std::min(leave, (speed > 0 ? behind : ahead) / speed);
    }
    return enter <= leave ? enter : kNever;
  }

  double alongOf(const Vec3& normal, double side) const {
    const btVector3 direction = toConvex_ * toBullet(Vec3(side * normal));
    return normal.dot(start_) +
           side * direction.dot(sweep_.m_convexShape->localGetSupportingVertex(direction));
  }

  // Whether the shape can reach a triangle from outside, early enough.
  bool mayMeet(const SurfaceTree::Corners& corners) const {
    Eigen::AlignedBox3d box;
    for (const Vec3& corner : corners) box.extend(corner);
    if (!(entry(box) < limit_)) return false;
    if (turns_) return true;
    const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    const double closing = -normal.dot(motion_), plane = normal.dot(corners[0]);
    if (!(closing > 0) || alongOf(normal, 1) + slack_ < plane) return false;
    return alongOf(normal, -1) - slack_ - plane < closing * (limit_ - gain_);
  }

  void meet(const SurfaceTree::Corners& corners) {
    if (!mayMeet(corners)) return;
    btTriangleShape triangle(toBullet(corners[0]), toBullet(corners[1]), toBullet(corners[2]));
    triangle.setMargin(sweep_.m_triangleCollisionMargin);
    const auto hit = castOnto(triangle, sweep_.m_triangleToWorld, sweep_, limit_);
    if (!hit) return;
    const btScalar taken =
        sweep_.reportHit(normalOf(*hit), hit->m_hitPoint, hit->m_fraction, -1, index_);
    limit_ = std::min<double>(limit_, taken);
  }

  // World frame. The cast's own at edges of the cloud.
  btVector3 normalOf(const btConvexCast::CastResult& hit) const {
    const btVector3 normal = hit.m_normal.normalized();
    const Vec3 local = toVec3(sweep_.m_triangleToWorld.invXform(hit.m_hitPoint));
    const auto own = field_.at(local);
    if (!own) return normal;
    const SmoothedPoint point = smoothedPoint(field_, local, *own);
    const btVector3 smooth = sweep_.m_triangleToWorld.getBasis() * toBullet(point.normal);
    return normal.dot(smooth) > (point.oneFace ? kOnFace : kBesideEdge) ? smooth : normal;
  }

  const SurfaceField& field_;
  int index_;
  btTriangleConvexcastCallback& sweep_;
  // In the cloud's frame [m]:
  btMatrix3x3 toConvex_;
  Vec3 start_, motion_;
  Eigen::AlignedBox3d box_;  // of the convex shape at the start
  double slack_ = 0, gain_ = 0;
  bool turns_ = false;
  double limit_;  // fraction of the hit to beat
};

}  // namespace

void castRay(const SurfaceField& field, int index, btTriangleRaycastCallback& ray) {
  const unsigned flags = ray.m_flags;
  const bool both = !(flags & btTriangleRaycastCallback::kF_FilterBackfaces);
  const bool turns = !(flags & btTriangleRaycastCallback::kF_KeepUnflippedNormal);
  visitCrossings(field, toVec3(ray.m_from), toVec3(ray.m_to), ray.m_hitFraction,
                 [&](const FieldHit& hit, bool enters) {
                   if (!(hit.fraction > 0) || (!enters && !both)) return true;
                   if (!(hit.fraction < ray.m_hitFraction)) return false;
                   const Vec3 normal = !enters && turns ? Vec3(-hit.normal) : hit.normal;
                   ray.m_hitFraction = ray.reportHit(
                       toBullet(normal), static_cast<btScalar>(hit.fraction), -1, index);
                   return hit.fraction < ray.m_hitFraction;
                 });
}

void castConvex(const SurfaceField& field, int index, btTriangleConvexcastCallback& sweep) {
  const RecognizedShape* const known = closedForm(field);
  if (!known) return ConvexSweep(field, index, sweep).run();
  const PlacedSolid* const form = &known->placed;
  const btTransform place = sweep.m_triangleToWorld * toBullet(form->place);
  const ConvexForm shape(form->solid);
  const auto hit = castOnto(*shape, place, sweep, sweep.m_hitFraction);
  if (!hit) return;
  const btVector3 normal = hit->m_normal.normalized();
  const SolidPoint at = solidAt(form->solid, toVec3(place.invXform(hit->m_hitPoint)));
  const btVector3 exact = place.getBasis() * toBullet(at.normal);
  sweep.reportHit(normal.dot(exact) > kBesideEdge ? exact : normal, hit->m_hitPoint,
                  hit->m_fraction, -1, index);
}

}  // namespace cloudcontact
