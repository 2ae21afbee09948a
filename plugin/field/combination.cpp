// Angles between faces, and which of them cross a voxel.
#include "field/combination.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

// How much of a sub-sample two faces leave together, if each alone leaves r and q: r q for faces at
// right angles, which cut independently; min(r, q) for parallel faces; max(0, r + q - 1) for
// opposite ones. Interpolated by the angle, which is exact where both run through the center. With
// min(r, q) throughout, edges lie 0.03 voxel inside.
Angle angleOf(const Eigen::Vector3f& n, const Eigen::Vector3f& m) {
  const float turn = std::acos(std::clamp(n.dot(m), -1.0f, 1.0f)) * (2.0f / 3.14159265f);
  return {std::max(1.0f - turn, 0.0f), std::max(turn - 1.0f, 0.0f)};
}

}  // namespace

Angle angleBetween(const FaceField& a, const FaceField& b) {
  return angleOf(a.face().n, b.face().n);
}

Combination combine(std::initializer_list<const FaceField*> faces, bool concave) {
  Combination c;
  c.concave = concave;
  for (const FaceField* face : faces) c.face[c.count++] = face;
  measureAngles(c);
  return c;
}

void measureAngles(Combination& c) {
  Angle* angle = c.angle;
  for (int j = 1; j < c.count; ++j)
    for (int i = 0; i < j; ++i) *angle++ = angleBetween(*c.face[i], *c.face[j]);
}

BlockCases casesOf(const Combination& c) {
  BlockCases cases;
  std::uint32_t beyond = 0, once = 0, crossed[kMostEdgeFaces];
  for (int i = 0; i < c.count; ++i) {
    const std::uint32_t outer = c.face[i]->outer(), inner = c.face[i]->inner();
    beyond |= kAllVoxels & (c.concave ? inner : outer);
    crossed[i] = kAllVoxels & ~(outer | inner);
    once |= crossed[i];
  }
  (c.concave ? cases.full : cases.empty) = beyond;
  (c.concave ? cases.empty : cases.full) = kAllVoxels & ~(beyond | once);
  cases.several = once & ~beyond;
  std::uint32_t second[kMostEdgeFaces] = {};  // where another face crosses the voxel
  for (int j = 1; j < c.count; ++j)
    for (int i = 0; i < j; ++i) {
      second[i] |= crossed[j];
      second[j] |= crossed[i];
    }
  for (int i = 0; i < c.count; ++i) {
    cases.only[i] = crossed[i] & ~(beyond | second[i]);
    cases.several &= ~cases.only[i];
  }
  return cases;
}

}  // namespace cloudcontact
