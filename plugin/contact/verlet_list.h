// Which samples a pair that hardly moves need look up again: Verlet's neighbour lists (L. Verlet,
// Phys. Rev. 159, 1967), with fields in the place of particles.
//
// Four of five samples that a query of a M16 thread looks up touch nothing. A list has those that
// may touch, or ask for finer ones, as long as none has come farther than a skin from where it was
// measured. What is found with it is what is found without it, to the bit: a sample is left out
// only where every record that it could meet within the skin, taken a skin deeper, still says
// nothing.
//
// Bodies that move farther than a tenth of a skin a query have no lists: to make these takes a look
// at all samples, and at the voxels beside them.
#pragma once

#include "contact/hits.h"

#include <array>
#include <span>

namespace cloudcontact {

// Of one body's samples on their way into the other.
struct Shortlist {
  std::vector<std::uint32_t> samples;  // of all levels, the coarsest's first; each level ascending
  std::array<std::uint32_t, kLevels> begin = {};  // of a level's
  CcWay way = {};                                 // where they were measured
  float skin = 0;                                 // [the other's voxels]

  std::span<const std::uint32_t> of(int level) const {
    const std::size_t first = begin[static_cast<std::size_t>(level)],
                      end = level > 0 ? begin[static_cast<std::size_t>(level - 1)] : samples.size();
    return std::span(samples).subspan(first, end - first);
  }
};

class ShortlistMaker;

// A pair's two lists, and how fast it moves. `ways` below are A's samples' into B and B's into A.
class Shortlists {
 public:
  // Begins a query. True where the lists hold for it, down to level().
  bool begin(const FieldData& a, const FieldData& b, const CcWay* ways, float margin);
  // Whether this query should make lists for those that follow; after begin() returned false.
  bool wanted() const { return wanted_; }
  // Makes them, of a query that came to an end on `level`. Keeps none where they need more room
  // than giveRoom() gave.
  void make(const FieldData& a, const FieldData& b, int level, float margin, ShortlistMaker& maker);
  void drop() { made_ = false; }
  // After a query without lists that looked up so many samples of A and of B: half as many are room
  // enough, so that a step that makes lists allocates nothing.
  void giveRoom(std::size_t ofA, std::size_t ofB);

  int level() const { return level_; }
  const Shortlist& of(Side sampled) const { return lists_[sampled]; }

 private:
  // A body's samples lie in this ball [own voxels].
  struct Ball {
    double center[3] = {0, 0, 0}, radius = 0;
  };
  static Ball ballOf(const SampleBricks& bricks);
  static double moved(const CcWay& from, const CcWay& to, const Ball& ball);
  void meet(const FieldData& a, const FieldData& b);
  bool hold(const CcWay* ways, float margin) const;

  std::shared_ptr<const int> lives_[2];  // of the fields that all this is about
  Ball balls_[2];
  CcWay last_[2] = {};  // the last query's
  Shortlist lists_[2];
  float margin_ = 0;  // [m] that they hold for
  float skins_[2] = {};
  int level_ = 0;
  bool known_ = false, made_ = false, wanted_ = false;
};

}  // namespace cloudcontact
