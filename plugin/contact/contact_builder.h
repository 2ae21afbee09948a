// From a pair's patches to its contact: forces, the pair's depth, points, and their IDs. The CPU
// and the device share it.
#pragma once

#include <cloudcontact/contact/contact.h>

#include <span>
#include <vector>

#include "base/byte_archive.h"
#include "contact/binner.h"
#include "contact/pair_depth.h"
#include "contact/pair_frame.h"
#include "contact/patch_hits.h"
#include "contact/touched_matter.h"
#include "kernels/contact/contact_patch.h"

namespace cloudcontact {

// The terms of the law for a pair; the search sets the gap.
CcTerms termsOf(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
                const PairFrame& frame);
// The number of hits that makes the coarsest level fine enough.
std::size_t enoughFor(const ContactSettings& settings);
// The edge of a bin's cell [m].
double cellOf(const PairFrame& frame, int level);

// The outcome of a search.
struct SearchOutcome {
  int level = 0;         // of the samples that hit
  std::size_t hits = 0;  // their number
  double gap = 0;        // HitSearch::gap()
};

// IDs that patches keep from step to step, so that a solver finds their points again. Places and
// normals are in A's frame, because the frame body may change from one step to the next.
class PatchIds {
 public:
  struct Patch {
    Vec3 center, normal;
    std::uint32_t id = 0;
  };
  // Gives each patch, in order, the ID of the nearest patch of the last step that is similar and
  // not taken yet, or a new ID; and remembers the patches.
  void assign(std::vector<Patch>& patches, double voxel);

  // For files (base/byte_archive.h).
  template <typename Archive>
  void keepIn(Archive& archive) {
    listIn(archive, known_,
           [](Archive& a, Patch& patch) { a(patch.center, patch.normal, patch.id); });
    archive(next_);
  }

 private:
  std::vector<Patch> known_;
  std::uint32_t next_ = 0;
};

// Gives the points of a result their IDs, four to a patch. `patches`: the result's, with IDs.
void giveIds(const std::vector<PatchIds::Patch>& patches, ContactResult& result);

// Builds the contact of one pair. It keeps its memory and the IDs between queries.
class ContactBuilder {
 public:
  // Validates the bodies (ContactFinder::find() says what throws) and clears the last result.
  PairFrame begin(const ContactBody& a, const ContactBody& b, const ContactSettings& settings);
  // Builds the result from the binner's last patches, all but the points' IDs. `matter`: what each
  // patch touches; empty if nothing depends on it. Returns whether there is any contact.
  bool build(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
             const PairFrame& frame, SearchOutcome outcome, const Binner& binner,
             const HitColumns& hits, PatchHits& wet, std::span<const PatchMatter> matter = {});
  // Adds such patches to the result, of near misses. Returns whether there are any.
  bool append(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
              const PairFrame& frame, SearchOutcome outcome, const Binner& binner,
              const HitColumns& hits, PatchHits& wet, std::span<const PatchMatter> matter);
  // Sets the hits, and adds a patch; for results that a device built.
  void setHits(std::size_t hits, int level) {
    result_.samples = hits;
    result_.level = level;
  }
  void add(const CcContactPatch& patch);
  // Gives the points their IDs and returns the result.
  const ContactResult& withIds();
  PatchIds& ids() { return ids_; }
  const ContactResult& latest() const { return result_; }

 private:
  struct FoundPatch {
    const CcSums* sums = nullptr;
    std::size_t index = 0;  // in the binner
    PatchMatter matter;     // if the law or the direction depends on it
    CcPatchForce force;
    CcFlat flat;                        // in the plane across its normal, if force.lean is not 0
    std::optional<KelvinVoigt> spring;  // of the pair, by the tissues that the patch touches
  };
  void makePatches(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
                   const PairFrame& frame, SearchOutcome outcome, const Binner& binner,
                   const HitColumns& hits, PatchHits& wet, std::span<const PatchMatter> matter);
  CcPairSums collect(const CcTerms& terms);
  void giveMatter(std::span<const PatchMatter> matter);
  double redirect();
  void emit(const CcTerms& terms, CcWhole whole, bool redirected, const PairHits& hits,
            PatchHits& wet);
  void setSprings(const ContactBody& a, const ContactBody& b, bool whole);

  std::vector<FoundPatch> found_;
  std::vector<CcContactPatch> contacts_;
  std::vector<PatchIds::Patch> patches_;  // of the result, in its order
  PatchIds ids_;
  double voxel_ = 0;  // the pair's [m]
  ContactResult result_;
};

}  // namespace cloudcontact
