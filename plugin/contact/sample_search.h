// What the search of a field and that of a shape have in common: one direction of a query, and what
// becomes of a sample whose depth is known.
#pragma once

#include "hits.h"

#include <algorithm>

namespace cloudcontact::search {

using V3 = Eigen::Vector3f;
using Candidates = HitSearch::Candidates;

// Half of a sample's width: over it the depth varies by the sine between the surfaces.
constexpr float kHalfWidth = 0.5f;
constexpr float kHalfDiagonal = 0.71f;
constexpr float kWide = 0.3f;  // [voxels] wider samples are taken in parts at an edge

// A sample farther off the other surface than kSlack [voxels] has no finer sample in its cell that
// touches: these lie at most kSlope beside it, times the sine between the surfaces, and both may
// bend by kSlack. By level.
constexpr float kSlack[kLevels] = {0, 0.25f, 0.8f}, kSlope[kLevels] = {0, 1.5f, 3.5f};

// Everything that one direction of the query needs.
struct Direction {
  const FieldData& body;
  const SampleSet& samples;
  int level;
  Side side;
  float voxel;              // of the samples' body [m]
  CcMap toFrame;            // samples' grid -> frame body, metres
  float frameFromOwn[9];    // turns the samples' normals into the frame
  float frameFromOther[9];  // turns the other body's normals into the frame
  float turnToOther[9];     // turns the samples' normals into the other body's frame
  CcMap toOther;            // samples' grid -> other's grid, voxels; unless that is a shape
  HitSearch::Misses& misses;
};

inline V3 applied(const CcMap& map, const V3& x) {
  V3 out;
  ccApply(&map, x.data(), out.data());
  return out;
}
inline V3 turned(const float* turn, const V3& x) {
  V3 out;
  ccTurn(turn, x.data(), out.data());
  return out;
}

// A sample at this depth [m] in the other body, whose normal there is `other` (its own frame): a
// hit, or a near miss.
void addHit(const Direction& dir, const SurfaceSample& s, float depth, const V3& other, bool deep,
            HitColumns& hits);
// The least depth [m] at which a sample may still be wet, or is a near miss.
inline float reachOf(const Direction& dir, float width) {
  return -std::max(kHalfWidth * width * dir.voxel, dir.level == 0 ? dir.misses.margin : 0.0f);
}

// Samples of `dir` looked up in another field.
void searchField(const Direction& dir, const FieldData& other, Candidates& candidates,
                 HitColumns& hits);
// Samples of `dir` against a shape's formula; `toShape` from their grid's frame, metres.
void searchShape(const Direction& dir, const AnalyticShape& shape, const Pose& toShape,
                 Candidates& candidates, HitColumns& hits);

}  // namespace cloudcontact::search
