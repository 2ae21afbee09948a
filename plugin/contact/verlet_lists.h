// Verlet lists of a pair (L. Verlet, Phys. Rev. 159, 1967), with fields in the place of particles:
// what a pair that hardly moves has to look up again.
//
// On an M16 thread, four of five samples that a query looks up touch nothing. A list holds copies
// of those that may touch. It is valid while no sample has moved farther than a skin from where the
// list was made. Results are the same to the bit: a sample is left out only if every record that it
// could meet within the skin, taken a skin deeper, says nothing. Most coarse samples need not be
// asked, either: too few may be hits for a search to end with them, and what they say of finer ones
// is the same within the skin (VerletList::Passed).
//
// Pairs that move farther than a tenth of a skin per query have no lists, since making one looks up
// all samples and the voxels beside them.
#pragma once

#include <memory>

#include "contact/verlet_list_builder.h"

namespace cloudcontact {

// The two lists of a pair, and how fast it moves. `ways`: of A's samples into B and of B's into A.
class VerletLists {
 public:
  // Begins a query. Returns whether the lists are valid for it, down to level(). `enough`: hits
  // that the coarsest level needs (neededOf()).
  bool begin(const FieldData& a, const FieldData& b, const CcWay* ways, std::size_t enough);
  // Whether this query should make lists for later ones; after begin() returned false.
  bool wanted() const { return wanted_; }
  // Makes lists in a query that ended on `level`. Keeps none that need more room than reserve()
  // made.
  void make(const FieldData& a, const FieldData& b, int level, std::size_t enough,
            VerletListBuilder& builder);
  void drop() { made_ = false; }
  // Reserves memory after a query without lists that ended on `level` with so many hits of A's and
  // B's samples, so that making lists allocates nothing.
  void reserve(int level, std::size_t ofA, std::size_t ofB);

  std::size_t bytesKept() const;

  int level() const { return level_; }
  // Whether no search ends on the level, so that VerletList::pass() takes the place of one.
  bool passes(int level) const { return passes_[static_cast<std::size_t>(level)]; }
  float age() const { return age_; }  // see VerletList::pass(); of the last begin()
  const VerletList& of(Side sampled) const { return lists_[sampled]; }

 private:
  // A ball around a body's samples [own voxels].
  struct Ball {
    double center[3] = {0, 0, 0}, radius = 0;
  };
  static Ball ballOf(const SampleBricks& bricks);
  static double moved(const CcWay& from, const CcWay& to, const Ball& ball);
  static float turnWithin(float skin, const CcWay& way, const Ball& ball);
  void meet(const FieldData& a, const FieldData& b);
  float ageAt(const CcWay* ways) const;

  std::shared_ptr<const int> lives_[2];  // of the two fields
  Ball balls_[2];
  CcWay last_[2] = {};                   // of the last query
  std::unique_ptr<VerletList[]> lists_;  // two, once there has been a touch
  std::array<bool, kLevels> passes_ = {};
  double motions_[2] = {};  // in the last query [the other's voxels]
  float skins_[2] = {};
  float age_ = 0;
  int level_ = 0;
  std::size_t enough_ = 0;
  std::size_t spare_ = 1;  // times as much room as most lists need, since one has needed more
  bool known_ = false, made_ = false, wanted_ = false;
};

}  // namespace cloudcontact
