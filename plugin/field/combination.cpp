// Angles between faces, and which of them bounds a voxel alone.
#include "field/combination.h"

#include "base/simd.h"

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

// Where one face lies farther outside than the other throughout a voxel. Over half a voxel's edge
// the difference of their distances changes by its gradient at the center, and by their bend.
CC_LANES void compare(const Face& a, const float* middleA, const Face& b, const float* middleB,
                      Angle& angle) {
  const float scaleA = a.n.lpNorm<1>() / kSub, scaleB = b.n.lpNorm<1>() / kSub;
  float n[3], c[3][3], bend = 0;
  for (int i = 0; i < 3; ++i) {
    n[i] = a.n[i] - b.n[i];
    for (int j = 0; j < 3; ++j) {
      c[i][j] = a.curvature(i, j) - b.curvature(i, j);
      bend += 0.125f * std::abs(c[i][j]);
    }
  }
  alignas(64) float apart[CC_WINDOW_LANES], most[CC_WINDOW_LANES];
  CC_INDEPENDENT
  for (int k = 0; k < CC_WINDOW_LANES; ++k) {
    const float x = static_cast<float>(k % 3 - 1), y = static_cast<float>(k / 3 % 3 - 1),
                z = static_cast<float>(k / 9 - 1);
    const float mx = n[0] + (c[0][0] * x + (c[0][1] * y + c[0][2] * z));
    const float my = n[1] + (c[1][0] * x + (c[1][1] * y + c[1][2] * z));
    const float mz = n[2] + (c[2][0] * x + (c[2][1] * y + c[2][2] * z));
    most[k] = 0.5f * (std::abs(mx) + (std::abs(my) + std::abs(mz))) + bend;
    apart[k] = middleA[k] * scaleA - middleB[k] * scaleB;
  }
  std::uint32_t more = 0, less = 0;
  for (std::uint32_t k = 0; k < CC_WINDOW_LANES; ++k) {
    more |= apart[k] > most[k] ? 1u << k : 0u;
    less |= -apart[k] > most[k] ? 1u << k : 0u;
  }
  angle.more = more & kAllVoxels;
  angle.less = less & kAllVoxels;
}

}  // namespace

Angle angleBetween(const FaceField& a, const FaceField& b) {
  Angle angle = angleOf(a.face().n, b.face().n);
  compare(a.face(), a.middle(), b.face(), b.middle(), angle);
  return angle;
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
  std::uint32_t beyond = 0, once = 0, crossed[kMostFaces];
  for (int i = 0; i < c.count; ++i) {
    const std::uint32_t outer = c.face[i]->outer(), inner = c.face[i]->inner();
    beyond |= kAllVoxels & (c.concave ? inner : outer);
    crossed[i] = kAllVoxels & ~(outer | inner);
    once |= crossed[i];
  }
  (c.concave ? cases.full : cases.empty) = beyond;
  (c.concave ? cases.empty : cases.full) = kAllVoxels & ~(beyond | once);
  cases.several = once & ~beyond;
  std::uint32_t second[kMostFaces] = {};  // where another face that crosses the voxel bounds it
  for (int j = 1; j < c.count; ++j)
    for (int i = 0; i < j; ++i) {
      const Angle& angle = c.between(i, j);
      second[i] |= crossed[j] & ~(c.concave ? angle.less : angle.more);
      second[j] |= crossed[i] & ~(c.concave ? angle.more : angle.less);
    }
  for (int i = 0; i < c.count; ++i) {
    cases.only[i] = crossed[i] & ~(beyond | second[i]);
    cases.several &= ~cases.only[i];
  }
  return cases;
}

}  // namespace cloudcontact
