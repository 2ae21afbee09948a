// TouchedMatter: what a contact's patches touch, by their collision voxels: the tissues of either
// body, (1) and (2), and the sum of base vectors (5').
#pragma once

#include <cloudcontact/contact/work_counts.h>

#include <span>
#include <utility>
#include <vector>

#include "contact/patch_map.h"
#include "contact/touched_voxels.h"

namespace cloudcontact {

// Sums over the collision voxels of a patch, of both bodies.
struct PatchMatter {
  double count[2] = {};                       // n of each body: sum of the voxels' shares
  double stiffness[2] = {}, damping[2] = {};  // sum of share times the tissue's k and c
  // Sum of share, hardness, ability and base vector: those of A's voxels less those of B's, in the
  // pair's frame [m]. `moment`: of the same about the frame's origin [m^2].
  Vec3 vectors = Vec3::Zero(), moment = Vec3::Zero();
  double lengths = 0;  // sum of their lengths [m]

  void add(const PatchMatter& other, double share);
};

// The hits that a query has found, and their bins.
struct FoundHits {
  const HitColumns& hits;
  const std::vector<Binner::Bin>& bins;
  std::size_t patches = 0;
  int level = 0;    // of the samples
  double cell = 0;  // of the bins [m]
  double gap = 0;   // HitSearch::gap() [m]
};

class TouchedMatter {
 public:
  // Whether the pair's law or direction depends on the matter touched.
  static bool wanted(const ContactBody& a, const ContactBody& b, const ContactSettings& settings);
  // One for each patch. Keeps its memory; valid until the next call.
  std::span<const PatchMatter> of(const ContactBody& a, const ContactBody& b,
                                  const ContactSettings& settings, const PairFrame& frame,
                                  const FoundHits& found);
  void clear() { matter_.clear(); }
  // What the passes since the last call took.
  WorkCounts takeWork() { return std::exchange(work_, {}); }

 private:
  void addBody(const ContactBody& own, const ContactBody& other, Side side, bool vectors,
               const PairFrame& frame, const FoundHits& found, double reach);
  void shareRest();

  PatchMap map_;
  std::vector<std::uint8_t> near_;  // which bricks are near hits
  std::vector<PatchMatter> matter_;
  WorkCounts work_;
  PatchMatter rest_;  // of voxels near no bin
};

// k and c of a pair that touches this matter, (1) and (2) for each body, and both in series. A body
// without tissues has its stated spring or is rigid.
KelvinVoigt springOf(const PatchMatter& matter, const ContactBody& a, const ContactBody& b);

}  // namespace cloudcontact
