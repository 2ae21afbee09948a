// TouchedMatter: what a contact's patches touch, by their collision voxels B: the tissues of either
// body, (1) and (2), and the sum of base vectors, (5) or (5').
//
// The search tells which samples' voxels may lie in the other body (TouchedSample). Each voxel of
// these is looked up there, and counts for the patch that its sample belongs to.
#pragma once

#include <cloudcontact/contact/work_counts.h>

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "contact/hit_search.h"
#include "contact/pair_frame.h"
#include "contact/patch_matter.h"

namespace cloudcontact {

class VoxelSums;

class TouchedMatter {
 public:
  TouchedMatter();
  ~TouchedMatter();
  // Whether the pair's law or direction depends on the matter touched.
  static bool wanted(const ContactBody& a, const ContactBody& b);
  // One for each patch. Keeps its memory; valid until the next call.
  std::span<const PatchMatter> of(const ContactBody& a, const ContactBody& b,
                                  const PairFrame& frame, const HitSearch& search,
                                  const FoundHits& found);
  // What the passes since the last call took.
  WorkCounts takeWork() { return std::exchange(work_, {}); }

 private:
  std::unique_ptr<VoxelSums> sums_;
  std::vector<search::TouchedSample> touched_;  // where D says what is touched
  std::vector<PatchMatter> matter_;
  WorkCounts work_;
};

// k and c of a pair that touches this matter, (1) and (2) for each body, and both in series. A body
// without tissues has its stated spring or is rigid.
KelvinVoigt springOf(const PatchMatter& matter, const ContactBody& a, const ContactBody& b);

}  // namespace cloudcontact
