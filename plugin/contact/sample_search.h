// What the search of a field and that of a shape have in common: one direction of a query, and what
// becomes of a sample whose depth is known.
#pragma once

#include "hits.h"
#include "sample.h"

#include <cmath>

namespace cloudcontact::search {

using M3 = Eigen::Matrix3f;
using V3 = Eigen::Vector3f;
using Candidates = HitSearch::Candidates;

// Half of a sample's width: over it the depth varies by the sine between the surfaces.
constexpr float kHalfWidth = 0.5f;
constexpr float kHalfDiagonal = 0.71f;
constexpr float kWide = 0.3f;  // [voxels] wider samples are taken in parts at an edge
constexpr std::uint32_t kNoCell = ~0u;

// A rigid map in float, x -> turn x + shift.
struct Map {
  M3 turn;
  V3 shift;
  V3 operator()(const V3& x) const { return turn * x + shift; }
};

// Everything that one direction of the query needs.
struct Direction {
  const FieldData& body;
  const SampleSet& samples;
  int level;
  Side side;
  float voxel;        // of the samples' body [m]
  Map toFrame;        // samples' grid -> frame body, metres
  M3 frameFromOwn;    // turns the samples' normals into the frame
  M3 frameFromOther;  // turns the other body's normals into the frame
  M3 toOther;         // samples' grid -> other's grid, voxels; directions only
  M3 turnToOther;     // the same without the voxels' ratio: turns normals
  HitSearch::Misses& misses;
};

// A sample at this depth [m] in the other body, whose normal there is `other` (its own frame): a
// hit, or a near miss.
void addHit(const Direction& dir, const SurfaceSample& s, float depth, const V3& other, bool deep,
            std::vector<Hit>& hits);
// The least depth [m] at which a sample may still be wet, or is a near miss.
inline float reachOf(const Direction& dir, const SurfaceSample& s) {
  return -std::max(kHalfWidth * s.width * dir.voxel, dir.level == 0 ? dir.misses.margin : 0.0f);
}

// Whether a finer sample in the cell may touch: `depth` in the samples' voxels, `normal` the other
// body's.
bool mayTouchBeside(const Direction& dir, const SurfaceSample& s, float depth, const V3& normal);

// The sample in parts; `at` tells depth [m] and normal of the other body at a place aside of the
// sample's own [its voxels]. Where the other body has an edge, depth is not linear over a wide
// sample: crossed edges turn by 11 deg at a depth of half a voxel without this.
template <typename At>
void addParts(const Direction& dir, const SurfaceSample& s, At&& at, std::vector<Hit>& hits) {
  const int parts = static_cast<int>(std::ceil(s.width / kWide));
  float t1[3], t2[3];
  ccTangents(s.normal, t1, t2);
  SurfaceSample part = s;
  part.width = s.width / static_cast<float>(parts);
  part.area = s.area / static_cast<float>(parts * parts);
  const Eigen::Map<const V3> u(t1), v(t2), middle(s.position);
  for (int k = 0; k < parts * parts; ++k) {
    const float a = (static_cast<float>(k % parts) - 0.5f * static_cast<float>(parts - 1)),
                b = (static_cast<float>(k / parts) - 0.5f * static_cast<float>(parts - 1));
    const V3 aside = part.width * (a * u + b * v);
    Eigen::Map<V3>(part.position) = middle + aside;
    const auto [depth, normal] = at(aside);
    addHit(dir, part, depth, normal, false, hits);
  }
}

// A cell near the other body: its finer cells are candidates of the next level. `last` is the cell
// that was so last.
inline void handOn(const Direction& dir, std::uint32_t cell, std::uint32_t& last,
                   Candidates& candidates) {
  if (dir.level == 0 || cell == last) return;
  last = cell;
  candidates.next.push_back(cell);
}

// Calls `with` for the finer cells of all that the coarser level handed on.
template <typename With>
void eachCandidate(const Direction& dir, const Candidates& candidates, With&& with) {
  const std::vector<SampleCell>& coarser = dir.samples.levels[dir.level + 1].cells;
  for (const std::uint32_t parent : candidates.now)
    for (std::uint32_t i = 0; i < coarser[parent].children; ++i) with(coarser[parent].child + i);
}

// Samples of `dir` looked up in another field; `toOther` from their grid to its, in voxels.
void searchField(const Direction& dir, const FieldData& other, const Map& toOther,
                 Candidates& candidates, std::vector<Hit>& hits);
// Samples of `dir` against a shape's formula; `toShape` from their grid's frame, metres.
void searchShape(const Direction& dir, const AnalyticShape& shape, const Pose& toShape,
                 Candidates& candidates, std::vector<Hit>& hits);

}  // namespace cloudcontact::search
