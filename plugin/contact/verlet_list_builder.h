// Which samples may touch as long as none comes farther than a skin from where it is now.
//
// As long as a sample stays in its voxel it is measured by the same record, whose planes fall by no
// more than it moves; where the skin reaches beyond the voxel, the records there are asked, too.
#pragma once

#include "contact/field_lanes.h"
#include "contact/verlet_list.h"

namespace cloudcontact {

namespace search {
struct MayTouch;  // what tells a sample that may touch from one that may not
}

class ShortlistMaker {
 public:
  // What a list must hold for.
  struct Until {
    int level = 0;     // the finest that is asked
    float margin = 0;  // [m]
    float turn = 0;    // [rad] of normals
  };
  // Fills the list for `own`'s samples at list.way; false where its memory is too small.
  bool make(const FieldData& own, const FieldData& other, const Until& until, Shortlist& list);

 private:
  using Direction = search::Direction;
  using Lanes = search::Lanes;
  using Test = search::MayTouch;

  void gather(const Direction& dir, const FieldData& other, float skin);
  void look(const Direction& dir, const FieldData& other, const Test& test);
  void lookBeside(const Direction& dir, const FieldData& other, const Test& test, int lane,
                  std::uint32_t place);
  void flushBeside(const Direction& dir, const FieldData& other, const Test& test);
  bool keep(int wanted, Shortlist& list);

  std::vector<std::uint32_t> bricks_, samples_, near_;  // of the level that is looked at
  std::vector<std::uint8_t> may_;                       // of samples_: CC_WET, CC_NEARBY
  Lanes lanes_, beside_;
  std::uint32_t owner_[search::kLanes];  // of samples_, beside_'s
};

}  // namespace cloudcontact
