// Speeds are bounded: each body's own, and its spin times the distance of its box's farthest
// corner.
#include "bullet/box_gap.h"

#include <LinearMath/btAabbUtil2.h>

#include "bullet/object_motion.h"

namespace cloudcontact {

namespace {

struct WorldBox {
  btVector3 low, high;

  explicit WorldBox(const btCollisionObjectWrapper& wrap) {
    wrap.getCollisionShape()->getAabb(wrap.getWorldTransform(), low, high);
  }
};

double speedOf(const btCollisionObjectWrapper& wrap, const WorldBox& box, double step) {
  const btCollisionObject& object = *wrap.getCollisionObject();
  const Motion motion = motionOf(object);
  const btVector3 center = object.getWorldTransform().getOrigin();
  btVector3 farthest = (box.high - center).absolute();
  farthest.setMax((box.low - center).absolute());
  return motion.linear.norm() + motion.angular.norm() * double(farthest.length()) +
         step * accelerationOf(object).norm();
}

}  // namespace

bool boxesStayApart(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                    double reach, double step) {
  const WorldBox one(a), other(b);
  btVector3 gap = one.low - other.high;
  gap.setMax(other.low - one.high);
  gap.setMax(btVector3(0, 0, 0));
  const double between = double(gap.length());
  if (!(between > reach)) return false;
  return between > step * (speedOf(a, one, step) + speedOf(b, other, step));
}

bool boxesMeet(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b) {
  const WorldBox one(a), other(b);
  return TestAabbAgainstAabb2(one.low, one.high, other.low, other.high);
}

}  // namespace cloudcontact
