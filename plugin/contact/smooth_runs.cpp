// Looks at the four places of each sample, and fits.
#include "contact/smooth_runs.h"

#include "contact/field_lanes.h"

#include <algorithm>

namespace cloudcontact::search {

namespace {

// [voxels] As far as the records of a smooth surface differ, beside a sample, from one quadric.
constexpr float kSmooth = 0.05f;
// Share of the reach of a sample's voxels at which the places are: there the quadric is exact.
constexpr float kPlaces = 0.7f;

V3 normalOf(const Lanes& lanes, int lane) {
  return {lanes.nx[lane], lanes.ny[lane], lanes.nz[lane]};
}

}  // namespace

void SmoothRuns::add(const Direction& dir, const OwnedVoxels::Level& level,
                     const TouchedSample& one) {
  const int i = count++;
  touched[i] = one;
  DepthQuadric& q = quadric[i];
  std::copy_n(level.runs[one.sample].at, 3, q.at);
  ccTurnBack(dir.turnToOther, one.other.data(), q.n);
  q.depth = one.depth / dir.voxel;
  aside[i] = kPlaces * level.reach[one.sample].aside;
  ccTangents(q.n, t1[i], t2[i]);
  for (int k = 0; k < 4; ++k) {
    const float* const t = k < 2 ? t1[i] : t2[i];
    const float by = k % 2 ? -aside[i] : aside[i];
    places.own.x[4 * i + k] = q.at[0] + by * t[0];
    places.own.y[4 * i + k] = q.at[1] + by * t[1];
    places.own.z[4 * i + k] = q.at[2] + by * t[2];
  }
}

namespace {

// What two places beside a sample, on both sides of it, tell of the depth along their line.
struct Along {
  float slope, bend;  // depth + slope u - bend u^2 / 2
  V3 turn;            // of the normal, per voxel

  Along(const Lanes& lanes, int first, float voxel, float depth, float aside) {
    const float a = lanes.depth[first] / voxel - depth, b = lanes.depth[first + 1] / voxel - depth;
    slope = (a - b) / (2 * aside);
    bend = -(a + b) / (aside * aside);
    turn = (normalOf(lanes, first) - normalOf(lanes, first + 1)) / (2 * aside);
  }
};

void setSix(const Eigen::Matrix3f& m, float* six) {
  for (int k = 0; k < 3; ++k) six[k] = m(k, k);
  six[3] = 2 * m(0, 1), six[4] = 2 * m(0, 2), six[5] = 2 * m(1, 2);
}

bool onePlaneEach(const Lanes& lanes, int first) {
  for (int k = first; k < first + 4; ++k)
    if (ccPlaneCount({lanes.a[k], lanes.b[k]}) != 1) return false;
  return true;
}

}  // namespace

void SmoothRuns::findQuadrics(const Direction& dir, const FieldData& other) {
  places.count = 4 * count;
  for (float* const column : {places.own.x, places.own.y, places.own.z}) pad(column, places.count);
  findRecords(dir, other, places);
  findDepths(static_cast<float>(other.cloud().voxelSize()), places);
  for (int i = 0; i < count; ++i) {
    DepthQuadric& q = quadric[i];
    q.smooth = onePlaneEach(places, 4 * i);
    if (!q.smooth) continue;
    const V3 u(t1[i]), v(t2[i]);
    const Along one(places, 4 * i, dir.voxel, q.depth, aside[i]),
        two(places, 4 * i + 2, dir.voxel, q.depth, aside[i]);
    V3 uThere, vThere;
    ccTurn(dir.turnToOther, t1[i], uThere.data());
    ccTurn(dir.turnToOther, t2[i], vThere.data());
    const float twist = 0.5f * (one.turn.dot(vThere) + two.turn.dot(uThere));
    // Normals and depths must tell the same.
    const float square = 0.5f * aside[i] * aside[i];
    const float off = std::max({aside[i] * std::abs(one.slope), aside[i] * std::abs(two.slope),
                                square * std::abs(one.turn.dot(uThere) - one.bend),
                                square * std::abs(two.turn.dot(vThere) - two.bend),
                                square * std::abs(one.turn.dot(vThere) - two.turn.dot(uThere))});
    q.smooth = off < kSmooth;
    V3::Map(q.n) -= one.slope * u + two.slope * v;
    const Eigen::Matrix3f uv = u * v.transpose();
    const Eigen::Matrix3f h =
        one.bend * u * u.transpose() + two.bend * v * v.transpose() + twist * (uv + uv.transpose());
    setSix(0.5f * h, q.h);
  }
}

}  // namespace cloudcontact::search
