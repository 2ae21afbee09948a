// The search for hits: samples of either body that lie in the other, level by level. Everything is
// in the pair's frame (PairFrame), in meters. docs/force.md, "Samples".
#pragma once

#include <utility>

#include "contact/near_misses.h"
#include "contact/pair_frame.h"
#include "contact/sample_search.h"

namespace cloudcontact {

// Whether a query needs to know which of the body's voxels lie in the other: by what it states, or
// by tissues that differ.
bool wantsVoxels(const ContactBody& own);
// D of a body, or null: all of it.
const PlacedSolid* areaOf(const ContactBody& body);

// Searches the samples of both bodies. It keeps its memory between calls.
class HitSearch {
 public:
  // Finds the hits of the coarsest level that gives `enough` of them (ContactSettings::samples), or
  // of all samples, and returns the level. Without hits, and if the bodies are nearer than `margin`
  // [m], it moves near misses together by gap() until they touch lightly, and returns those as
  // hits. With `runner` large levels run in parallel; the hits are the same to the bit.
  int run(const ContactBody& a, const ContactBody& b, const PairFrame& frame, double margin,
          std::size_t enough, HitColumns& hits, const TaskRunner* runner = nullptr);
  // The same without the search for hits: for bodies whose hits press nothing, such as the sides of
  // two boxes whose faces are a tenth of a voxel apart.
  void runApart(const ContactBody& a, const ContactBody& b, const PairFrame& frame, double margin,
                HitColumns& hits);
  // Near misses beside where the bodies are known to meet (KnownMeets). Returns whether there
  // are any.
  bool runBeside(const ContactBody& a, const ContactBody& b, const PairFrame& frame, double margin,
                 const KnownMeets& known, HitColumns& hits);
  static constexpr std::size_t kAll = search::kAllSamples;
  double gap() const { return gap_; }  // [m] 0: the hits are real
  // Of near misses, by hit: how deep each ends that is moved together, at an edge of its body, too.
  const std::vector<float>& ends() const { return ends_; }
  // Of the last run's level: the samples whose voxels may lie in the other body, where those are
  // wanted (wantsVoxels()) and the other body itself says what lies in it, not a D.
  std::span<const search::TouchedSample> touched(Side side) const {
    return candidates_[side].touched;
  }
  // Samples that the last run looked up, on all levels.
  std::size_t lookups() const {
    return candidates_[0].work.samples + candidates_[1].work.samples + near_.samples;
  }
  // What the runs since the last call took.
  WorkCounts takeWork() { return std::exchange(work_, {}); }
  // Reserves what `other` has reserved.
  void reserveLike(const HitSearch& other);

 private:
  struct Query;
  static Query queryOf(const ContactBody& a, const ContactBody& b, const PairFrame& frame,
                       std::size_t enough);
  int searchLevels(const Query& query, HitColumns& hits);
  void searchSide(const Query& query, Side side, int level, HitColumns& hits);
  void touchLightly(const Query& query, const PairFrame& frame, float margin, HitColumns& hits,
                    const KnownMeets* known = nullptr);
  void begin(bool wantsCoarse, HitColumns& hits);
  void end();

  search::Candidates candidates_[2];
  search::CoarseFound coarse_[2];
  NearMissSearch misses_;
  WorkCounts near_;  // of the last search for near misses
  WorkCounts work_;
  search::Shares shares_;
  double gap_ = 0;
  std::vector<float> ends_;
};

}  // namespace cloudcontact
