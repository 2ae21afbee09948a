// What the search of a field and that of a shape have in common: one direction of a query, and what
// becomes of a sample whose depth is known.
#pragma once

#include "contact/hits.h"
#include "kernels/contact/search.h"

#include <algorithm>
#include <span>

namespace cloudcontact::search {

using V3 = Eigen::Vector3f;
using Candidates = HitSearch::Candidates;

// Everything that one direction of the query needs.
struct Direction : CcWay {
  const FieldData& body;
  const SampleSet& samples;
  int level;
  Side side;
  float voxel;  // of the samples' body [m]
  HitSearch::Misses& misses;
  // The level's samples that need be looked up, ascending; null: all of them.
  const std::span<const std::uint32_t>* listed = nullptr;
  std::size_t needed = HitSearch::kAll;  // hits of both bodies with which the level is fine enough

  // The same with misses of its own.
  Direction with(HitSearch::Misses& own) const {
    return {
        static_cast<const CcWay&>(*this), body, samples, level, side, voxel, own, listed, needed};
  }
  CcLimits limits() const { return ccLimitsOf(level, voxel, misses.margin); }
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

// Samples of `dir` looked up in another field.
void searchField(const Direction& dir, const FieldData& other, Candidates& candidates,
                 HitColumns& hits, HitSearch::Shares& shares);
// Samples of `dir` against a shape's formula; `toShape` from their grid's frame, metres.
void searchShape(const Direction& dir, const Solid& shape, const Pose& toShape,
                 Candidates& candidates, HitColumns& hits, HitSearch::Shares& shares);

}  // namespace cloudcontact::search
