// How Verlet lists are made: which samples may touch while none moves farther than a skin.
//
// While a sample stays in its voxel it is measured by the same record, whose planes' depths change
// by no more than it moves. If the skin reaches beyond the voxel, the records there count too.
#pragma once

#include <array>
#include <utility>

#include "contact/field_lanes.h"
#include "contact/verlet_list.h"

namespace cloudcontact {

namespace search {
struct MayTouch;  // what a record says of a sample within the skin
}

class VerletListBuilder {
 public:
  // The queries for which lists are valid.
  struct Limits {
    int level = 0;           // the finest level searched
    std::size_t enough = 0;  // hits that the coarsest level needs
  };
  // Fills two lists with samples of each of the fields on their way into the other one, at
  // VerletList::way, and says which levels are passed. Returns false if their memory is too small.
  bool build(const FieldData* const* fields, const Limits& limits, VerletList* lists,
             std::array<bool, kLevels>& passes);
  // What the lists since the last call took.
  WorkCounts takeWork() { return std::exchange(work_, {}); }

 private:
  using Direction = search::Direction;
  using Lanes = search::Lanes;
  using Test = search::MayTouch;
  // Of one body, on the current level: the runs of samples to measure, one for each cell of the
  // coarser level that is kept; the samples, and what records say of them (MayTouch).
  struct Side {
    std::vector<SampleRun> runs;
    std::vector<std::uint32_t> samples;
    std::vector<std::uint8_t> may;
    std::vector<float> same, dry;
  };

  void gather(const Direction& dir, const FieldData& other, float skin, Side& side);
  void look(const Direction& dir, const FieldData& other, const Test& test, Side& side);
  void lookBeside(const Direction& dir, const FieldData& other, const Test& test, int lane,
                  std::uint32_t place, Side& side);
  void flushBeside(const Direction& dir, const FieldData& other, const Test& test, Side& side);
  bool keep(const SampleSet& from, int level, bool last, bool passed, Side& side, VerletList& list);
  bool keepWet(const SampleColumns& from, std::size_t begin, std::size_t end, const Side& side,
               SampleColumns& to, VerletList& list);
  bool keepCells(const SampleLevel& from, int level, bool passed, std::size_t begin,
                 std::size_t end, const Side& side, VerletList& list);

  std::vector<std::uint32_t> bricks_;
  std::vector<SampleRun> finer_;  // of the cells that are kept
  Side sides_[2];
  Lanes lanes_, beside_;
  WorkCounts work_;
  float begins_[search::kLanes];  // for each lane of beside_, the age at which its record counts
  std::uint32_t owner_[search::kLanes];  // for each lane of beside_, its sample's place in samples
};

}  // namespace cloudcontact
