// Motions with this step's gravity; triangles are read along the way.
#include "bullet/pair_sweep.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "bullet/object_motion.h"

namespace cloudcontact {

namespace {

// The velocity with which Bullet would move the object in this step if it met nothing.
Motion freeMotionOf(const btCollisionObject& object, double step) {
  Motion motion = motionOf(object);
  motion.linear += step * accelerationOf(object);
  return motion;
}

constexpr double kEndless = 1e9;  // [m] a plane's bounds are larger

double farthestOf(const btCollisionShape& shape) {
  btVector3 center;
  btScalar radius;
  shape.getBoundingSphere(center, radius);
  const double reach = double(center.length() + radius);
  return reach < kEndless ? reach : 0;
}

double spinOf(const btCollisionObject& object, const Motion& motion) {
  const double spin = motion.angular.norm();
  return spin > 0 ? spin * farthestOf(*object.getCollisionShape()) : 0;
}

}  // namespace

double sweptFrom(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b) {
  double least = std::numeric_limits<double>::infinity();
  for (const btCollisionObjectWrapper* wrap : {&a, &b}) {
    const btCollisionObject& object = *wrap->getCollisionObject();
    if (object.getCcdMotionThreshold() > 0 && !object.isStaticOrKinematicObject())
      least = std::min(least, double(object.getCcdMotionThreshold()));
  }
  return least;
}

bool isSwept(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
             const btDispatcherInfo& info) {
  const double least = sweptFrom(a, b);
  const double step = double(info.m_timeStep);
  if (!info.m_useContinuous || !(step > 0) || least == std::numeric_limits<double>::infinity())
    return false;
  const btCollisionObject &one = *a.getCollisionObject(), &other = *b.getCollisionObject();
  const Motion first = freeMotionOf(one, step), second = freeMotionOf(other, step);
  const double speed =
      (first.linear - second.linear).norm() + spinOf(one, first) + spinOf(other, second);
  return step * speed > least;
}

// Triangles near the cloud are read anew after each motion by its own size.
std::optional<Touch> PairSweep::throughTriangles(ContactBody a, ContactBody b,
                                                 const btCollisionShape& triangles, double step) {
  ContactBody &cloud = a.field ? a : b, &mesh = a.field ? b : a;
  const Vec3 arm = cloud.pose.position - mesh.motion.center;
  const double speed = (cloud.motion.linear - mesh.motion.at(cloud.pose.position)).norm() +
                       cloud.motion.angular.norm() * cloud.field->bounds().diagonal().norm() +
                       mesh.motion.angular.norm() * arm.norm();
  if (!std::isfinite(speed)) return std::nullopt;
  constexpr double kMostStrides = 2000;
  const double stride =
      std::max(cloud.field->bounds().diagonal().norm(), speed * step / kMostStrides);
  const int count = std::max(1, static_cast<int>(std::ceil(speed * step / stride)));
  Vec3 checked = Vec3::Zero();
  for (int i = 0; i < count; ++i) {
    const double from = step * i / count, until = step * (i + 1) / count;
    ContactBody there = cloud;
    there.pose = movedOn(cloud.pose, cloud.motion, from);
    mesh.shape =
        triangles_.of(triangles, movedOn(mesh.pose, mesh.motion, from), there, stride, reading_);
    if (!mesh.shape) continue;
    auto touch = touch_.find(a, b, from, until);
    checked += touch_.checked();
    if (touch) touch->checked = checked;
    if (touch) return touch;
    a.motion.linear -= touch_.checked();
  }
  return std::nullopt;
}

std::optional<Touch> PairSweep::find(const PairQuery& query, const btCollisionObjectWrapper& a,
                                     const btCollisionObjectWrapper& b, double step) {
  ContactBody bodies[2] = {query.a, query.b};
  const btCollisionObjectWrapper* const wraps[2] = {&a, &b};
  for (int side = 0; side < 2; ++side) {
    bodies[side].motion = freeMotionOf(*wraps[side]->getCollisionObject(), step);
    bodies[side].tissues = nullptr;
    bodies[side].spring.reset();
    if (!bodies[side].motion.linear.allFinite() || !bodies[side].motion.angular.allFinite())
      return std::nullopt;
  }
  std::optional<Touch> touch;
  int triangles = -1;
  for (int side = 0; side < 2; ++side) {
    const ContactBody& body = bodies[side];
    if (!body.field && (!body.shape || std::holds_alternative<SurfaceSolid>(*body.shape)))
      triangles = side;
  }
  if (triangles >= 0)
    touch = throughTriangles(bodies[0], bodies[1], *wraps[triangles]->getCollisionShape(), step);
  else
    touch = touch_.find(bodies[0], bodies[1], 0, step);
  // This step's forces: the contact has the velocities without them.
  if (touch)
    touch->checked -= (bodies[0].motion.linear - query.a.motion.linear) -
                      (bodies[1].motion.linear - query.b.motion.linear);
  return touch;
}

}  // namespace cloudcontact
