// Separating axes of two boxes: their faces' normals and the cross products of their edges.
// (Gottschalk, Lin, Manocha: OBBTree, SIGGRAPH 1996.)
#include "contact/far_apart.h"

namespace cloudcontact {

namespace {

Eigen::AlignedBox3d boxOf(const ContactBody& body) {
  return body.field ? body.field->bounds() : boundsOf(*body.shape);
}

// A half-space has no box: the other's lowest corner tells.
bool farFrom(const HalfSpace& plane, const Pose& planePose, const ContactBody& body, double reach) {
  const Eigen::AlignedBox3d box = boxOf(body);
  const Vec3 normal = body.pose.orientation.conjugate() * (planePose.orientation * plane.normal);
  const double middle =
      plane.normal.dot(planePose.toLocal(body.pose.toWorld(box.center()))) - plane.offset;
  return middle - (box.sizes() / 2).dot(normal.cwiseAbs()) > reach;
}

const HalfSpace* planeOf(const ContactBody& body) {
  return body.shape ? std::get_if<HalfSpace>(body.shape) : nullptr;
}

}  // namespace

bool farApart(const ContactBody& a, const ContactBody& b, double reach) {
  if (const HalfSpace* const plane = planeOf(a)) return farFrom(*plane, a.pose, b, reach);
  if (const HalfSpace* const plane = planeOf(b)) return farFrom(*plane, b.pose, a, reach);
  const Eigen::AlignedBox3d boxA = boxOf(a), boxB = boxOf(b);
  const Vec3 halfA = boxA.sizes() / 2, halfB = boxB.sizes() / 2;
  const Pose bInA = a.pose.inverse() * b.pose;
  const Eigen::Matrix3d turn = bInA.orientation.toRotationMatrix();  // columns: B's axes
  const Vec3 way = bInA.toWorld(boxB.center()) - boxA.center();
  const auto parted = [&](const Vec3& axis) {
    const double spread =
        halfA.dot(axis.cwiseAbs()) + halfB.dot((turn.transpose() * axis).cwiseAbs());
    return std::abs(way.dot(axis)) - spread > reach * axis.norm();
  };
  for (int i = 0; i < 3; ++i)
    if (parted(Vec3::Unit(i)) || parted(turn.col(i))) return true;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      const Vec3 axis = Vec3::Unit(i).cross(turn.col(k));
      if (axis.squaredNorm() > 1e-6 && parted(axis)) return true;  // else the edges are parallel
    }
  return false;
}

}  // namespace cloudcontact
