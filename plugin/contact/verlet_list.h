// A Verlet list: what one body's samples must be asked while none moves farther than a skin.
#pragma once

#include "contact/sample_search.h"

namespace cloudcontact {

// Samples of one body on their way into the other.
struct VerletList {
  // Copies of the samples that must be asked, ascending on each level, so that a search of this set
  // finds what a search of all finds. On a level that is passed: of those that must be asked there.
  SampleSet set;
  // A level on which no search ends, so that it tells only where finer samples may touch.
  struct Passed {
    // For each cell: the samples to be asked whether finer ones of it may touch. None: they may,
    // wherever within the skin.
    std::vector<SampleRun> cells;
    // Of each of those samples: what it says, and up to which age of the list that is true.
    std::vector<std::uint8_t> near;
    std::vector<float> until;
  };
  Passed passed[kLevels];
  // Of each sample of the finest level: up to which age of the list it is no hit.
  std::vector<float> dry;
  CcWay way = {};  // where they were measured
  float skin = 0;  // [the other's voxels]
  float turn = 0;  // by which normals may turn

  // Takes the place of a search of a level that it does not end on: of the cells in `candidates`,
  // finds those of which finer samples may touch. `dir`: into `other`, with the list's set. `age`:
  // how much of the skin and of the turn that the list is made for is used up, 0 to 1.
  void pass(const search::Direction& dir, const FieldData& other, float age,
            search::Candidates& candidates) const;
  void clear();
  // Takes the place of Candidates::runs, on the finest level: those samples of them that may be
  // hits at this age.
  void choose(float age, search::Candidates& candidates) const;
  // Makes room for `count` samples on each level from the coarsest to `level`.
  void reserve(int level, std::size_t count);
  std::size_t bytes() const;
};

}  // namespace cloudcontact
