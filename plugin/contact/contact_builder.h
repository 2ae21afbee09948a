// From a pair's patches to its contact: forces, the pair's depth, points, and their IDs. The CPU
// and the device share it.
#pragma once

#include <cloudcontact/contact/contact.h>

#include <span>
#include <vector>

#include "base/byte_archive.h"
#include "contact/pair_depth.h"
#include "contact/pair_frame.h"
#include "contact/query_memory.h"
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
  // The patches of a result, in its order: after begin() one add() each, with the middle of its
  // area and its normal.
  void begin() { now_.clear(); }
  void add(const Vec3& middle, const Vec3& normal) { now_.push_back({middle, normal}); }
  // Before the patches of a result that may not be used, and again if it is not.
  void setAside() { std::swap(now_, aside_); }
  // Gives each patch, in order, the ID of the nearest patch of the last step that is similar and
  // not taken yet, or a new ID, and its points four of their own; and remembers the patches.
  // `voxel`: the pair's [m].
  void give(ContactResult& found, double voxel);

  std::size_t bytesKept() const {
    return (known_.capacity() + now_.capacity() + aside_.capacity()) * sizeof(Place);
  }
  // For files (base/byte_archive.h).
  template <typename Archive>
  void keepIn(Archive& archive) {
    listIn(archive, known_,
           [](Archive& a, Place& patch) { a(patch.middle, patch.normal, patch.id); });
    archive(next_);
  }

 private:
  struct Place {
    Vec3 middle, normal;
    std::uint32_t id = 0;
  };
  std::vector<Place> known_, now_, aside_;
  std::uint32_t next_ = 0;
};

// Sets the hits, unless all patches so far are gaps: where others touch, gaps are beside.
void setHits(std::size_t hits, int level, ContactResult& found);

// Builds the contact of one pair. It keeps its memory and the IDs between queries.
class ContactBuilder {
 public:
  // Validates the bodies (ContactFinder::find() says what throws) and clears the result.
  PairFrame begin(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
                  ContactResult& found);
  // Adds the binner's last patches to the result, all but the points' IDs, and states the error of
  // its depth. `matter`: what each patch touches; empty if nothing depends on it.
  void build(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
             const PairFrame& frame, SearchOutcome outcome, QueryMemory& memory,
             std::span<const PatchMatter> matter, ContactResult& result);
  // Adds a patch and its points; for results that a device built.
  void add(const CcContactPatch& patch, ContactResult& found);
  // Gives the points of the last result their IDs.
  void giveIds(ContactResult& found) { ids_.give(found, voxel_); }
  PatchIds& ids() { return ids_; }
  std::size_t bytesKept() const {
    return found_.capacity() * sizeof(FoundPatch) + contacts_.capacity() * sizeof(CcContactPatch) +
           ids_.bytesKept();
  }

 private:
  struct FoundPatch {
    const CcSums* sums = nullptr;
    std::size_t index = 0;  // in the binner
    PatchMatter matter;     // if the law or the direction depends on it
    CcPatchForce force;
    CcFlat flat;                        // in the plane across its normal, if force.lean is not 0
    std::optional<KelvinVoigt> spring;  // of the pair, by the tissues that the patch touches
  };
  CcPairSums collect(const CcTerms& terms);
  void giveMatter(std::span<const PatchMatter> matter);
  double redirect();
  void emit(const CcTerms& terms, CcWhole whole, double ended, bool redirected, double cell,
            QueryMemory& memory, ContactResult& result);
  void setSprings(const ContactBody& a, const ContactBody& b, bool whole);

  std::vector<FoundPatch> found_;
  std::vector<CcContactPatch> contacts_;
  PatchIds ids_;
  double voxel_ = 0;  // the pair's [m]
};

}  // namespace cloudcontact
