// Midpoint quadrature over the triangles, and bisection.
#include "lab/oracle.h"

#include <algorithm>

#include "scene/mesh_distance.h"

namespace cloudcontact::program::lab {
namespace {

// Sums the force on the part of a surface inside `other`, in the frame of `other`.
struct Quadrature {
  const MeshDistance& other;
  Pose pose;  // of the mesh in the other's frame
  double spacing;
  OracleForce sum{};
  int hint = 0;

  void add(const Vec3& a, const Vec3& b, const Vec3& c) {
    const double ab = (b - a).norm(), bc = (c - b).norm(), ca = (a - c).norm();
    const double longest = std::max({ab, bc, ca});
    const Vec3 middle = (a + b + c) / 3;
    if (other.bounds().exteriorDistance(middle) > longest) return;
    if (longest > spacing) {
      // Bisecting the longest edge keeps triangles well shaped.
      if (longest == ab) return cut(a, b, c);
      return longest == bc ? cut(b, c, a) : cut(c, a, b);
    }
    const double depth = other.depth(middle, spacing, &hint);
    if (!(depth > 0)) return;
    const Vec3 force = -0.5 * depth * (b - a).cross(c - a);
    sum.force += force;
    sum.torque += middle.cross(force);
    sum.deepest = std::max(sum.deepest, depth);
  }
  void cut(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 middle = (a + b) / 2;
    add(a, middle, c);
    add(middle, b, c);
  }
};

OracleForce pressOn(const Mesh& mesh, const Pose& pose, const Mesh& other, double spacing) {
  const MeshDistance distance(other);
  Quadrature quadrature{distance, pose, spacing};
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const auto corner = [&](int k) {
      return pose.toWorld(mesh.vertices[static_cast<std::size_t>(t[k])]);
    };
    quadrature.add(corner(0), corner(1), corner(2));
  }
  return quadrature.sum;
}

}  // namespace

OracleForce foundationForce(const Mesh& a, const Mesh& b, const Pose& poseOfB, double spacing) {
  const OracleForce onB = pressOn(b, poseOfB, a, spacing);
  // The force on A, rotated from B's frame and reversed, acts on B.
  const OracleForce onA = pressOn(a, poseOfB.inverse(), b, spacing);
  const Vec3 force = -(poseOfB.orientation * onA.force);
  const Vec3 torque = -(poseOfB.orientation * onA.torque) + poseOfB.position.cross(force);
  return {(onB.force + force) / 2, (onB.torque + torque) / 2, std::max(onB.deepest, onA.deepest)};
}

double distanceUntil(const Mesh& a, const Mesh& b, const Pose& poseOfB, const Vec3& way,
                     double depth, double reach) {
  const MeshDistance distance(a);
  const std::vector<Vec3> points = surfacePoints(b, 4000);
  const auto deepest = [&](double moved) {
    double most = -reach;
    int hint = 0;
    for (const Vec3& p : points)
      most = std::max(most, distance.depth(poseOfB.toWorld(p) + moved * way, reach, &hint));
    return most;
  };
  // Advance by the gap, which cannot touch; near contact by `depth`; then bisect.
  double low = 0, high = 0;
  for (double now = deepest(0); high < reach && now < depth; now = deepest(high))
    low = high, high += std::max(depth, -now);
  for (int k = 0; k < 12; ++k) {
    const double middle = (low + high) / 2;
    (deepest(middle) < depth ? low : high) = middle;
  }
  return high;
}

}  // namespace cloudcontact::program::lab
