// A Verlet list, and how it is made: which samples may touch while none moves farther than a skin.
//
// While a sample stays in its voxel it is measured by the same record, whose planes' depths change
// by no more than it moves. If the skin reaches beyond the voxel, the records there count too.
#pragma once

#include <array>
#include <span>
#include <utility>

#include "contact/field_lanes.h"

namespace cloudcontact {

namespace search {
struct MayTouch;  // whether a sample may touch
}

// Samples of one body on their way into the other.
struct VerletList {
  std::vector<std::uint32_t> samples;  // of all levels, coarsest first; ascending in each level
  std::array<std::uint32_t, kLevels> begin = {};  // of each level in `samples`
  CcWay way = {};                                 // where they were measured
  float skin = 0;                                 // [the other's voxels]

  std::span<const std::uint32_t> of(int level) const {
    const std::size_t first = begin[static_cast<std::size_t>(level)],
                      end = level > 0 ? begin[static_cast<std::size_t>(level - 1)] : samples.size();
    return std::span(samples).subspan(first, end - first);
  }
};

class VerletListBuilder {
 public:
  // The queries for which a list is valid.
  struct Limits {
    int level = 0;   // the finest level searched
    float turn = 0;  // [rad] of normals
  };
  // Fills the list with samples of `own` at list.way. Returns false if its memory is too small.
  bool build(const FieldData& own, const FieldData& other, const Limits& limits, VerletList& list);
  // What the lists since the last call took.
  WorkCounts takeWork() { return std::exchange(work_, {}); }

 private:
  using Direction = search::Direction;
  using Lanes = search::Lanes;
  using Test = search::MayTouch;

  void gather(const Direction& dir, const FieldData& other, float skin);
  void look(const Direction& dir, const FieldData& other, const Test& test);
  void lookBeside(const Direction& dir, const FieldData& other, const Test& test, int lane,
                  std::uint32_t place);
  void flushBeside(const Direction& dir, const FieldData& other, const Test& test);
  bool keep(int wanted, VerletList& list);

  std::vector<std::uint32_t> bricks_, samples_, near_;  // of the current level
  std::vector<std::uint8_t> may_;                       // of samples_: CC_WET, CC_NEARBY
  Lanes lanes_, beside_;
  WorkCounts work_;
  std::uint32_t owner_[search::kLanes];  // for each lane of beside_, its sample's place in samples_
};

}  // namespace cloudcontact
