// A ContactFinder's memory and the last steps of a query, which other backends share: patches to
// forces, points and names.
#pragma once

#include <cloudcontact/contact/contact_finder.h>

#include "contact/pair_depth.h"
#include "contact/patch_names.h"
#include "contact/sums.h"
#include "contact/verlet_list.h"
#include "kernels/contact/contact_patch.h"

#include <span>

namespace cloudcontact {

// What a search came to.
struct Hitting {
  int level = 0;          // of the samples that hit
  std::size_t count = 0;  // hits
  double gap = 0;         // HitSearch::gap()
};

struct FoundPatch {
  const Sums* sums = nullptr;
  CcPatchForce force;
  CcFlat flat;  // across its normal, where force.lean is not 0
};

// What the law makes of a pair's patches; the gap is the search's to tell.
CcTerms termsOf(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
                const PairFrame& frame);
// Hits that a query asks its coarsest level for.
std::size_t enoughFor(const ContactSettings& settings);
// A bin's edge [m].
double cellOf(const PairFrame& frame, int level);

struct ContactFinder::Scratch {
  std::vector<FoundPatch> found;
  std::vector<NamedPatch> seen;  // of the result, in its order
  PatchNames names;
  Shortlists lists;
  double voxel = 0;       // the pair's [m]
  std::size_t asked = 0;  // samples looked up
  ContactResult result;

  // Of a finder, for those who know how to finish.
  static Scratch& of(ContactFinder& finder) { return *finder.scratch_; }

  // Checks the bodies (ContactFinder::find() tells what throws), and forgets the last query.
  PairFrame begin(const ContactBody& a, const ContactBody& b);
  // The result from the patches' sums, but for its points' names; `hits` where a body is a shape.
  void finish(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
              const PairFrame& frame, Hitting hitting, std::span<const Sums> patches,
              const HitColumns* hits = nullptr);
  // One patch more for the result, as a device has it.
  void take(const CcContactPatch& patch);
  const ContactResult& named();

 private:
  CcPairSums collect(const CcTerms& terms);
  void emit(const CcTerms& terms, CcWhole whole);
};

}  // namespace cloudcontact
