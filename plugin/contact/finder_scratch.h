// A ContactFinder's memory and the last steps of a query, which other backends share: patches to
// forces, points and names.
#pragma once

#include "pair_depth.h"
#include "patch_names.h"
#include "shortlist.h"

#include <span>

namespace cloudcontact {

// What a search came to.
struct Hitting {
  int level = 0;          // of the samples that hit
  std::size_t count = 0;  // hits
  double gap = 0;         // HitSearch::gap()
};

// Hits that a query asks its coarsest level for.
std::size_t enoughFor(const ContactSettings& settings);
// A bin's edge [m].
double cellOf(const PairFrame& frame, int level);

struct ContactFinder::Scratch {
  std::vector<FoundPatch> found;
  std::vector<NamedPatch> seen;  // of the result, in its order
  PatchNames names;
  Shortlists lists;
  double voxel = 0;  // the pair's [m]
  double gap = 0;
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
  const ContactResult& named();

 private:
  void collect(bool foundation, bool oneSided, Side sampled);
  void emit(const PairFrame& frame, const Pose& poseOfA, const ContactSettings& settings,
            double depth, bool oneSided);
};

}  // namespace cloudcontact
