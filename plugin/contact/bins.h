// The second half of a query, first step: hits gathered in bins, an 8-voxel cell times one of six
// directions each, and bins grown together to patches.
#pragma once

#include <cloudcontact/base/task_runner.h>
#include <cloudcontact/contact/contact.h>

#include "contact/sums.h"

#include <cstdint>
#include <vector>

namespace cloudcontact {

// Groups hits into patches; keeps its memory.
class Binner {
 public:
  // Sums of each patch, in a fixed order. `cell` [m]: a bin's edge; `oneSided`: the other body is a
  // shape without samples, and each hit stands for its surface too.
  // `shareOut`, where there is one: many hits are summed up over it, to the same bits.
  const std::vector<Sums>& patches(const HitColumns& hits, double cell, bool oneSided,
                                   const TaskRunner* shareOut = nullptr);
  // Room for what the other has room for.
  void fit(const Binner& other);

 private:
  // A bin: which cell and direction, and what it came to.
  struct Bin {
    std::int32_t cell[3];
    std::int32_t next = -1;  // another free bin of the same cell, -1: none
    std::int32_t patch = -1;
    std::uint32_t end = 0;  // of its hits in order_
    std::size_t run = 0;    // its first of runs_
    double weight = 0;      // of its forces
    CcFaces faces = {};
  };
  void findBins(const HitColumns& hits, double cell);
  void findBox(int count);
  void findPlaces(int count);
  void addTo(std::uint32_t bin, std::size_t hit);
  std::uint32_t binOf(std::uint64_t key);
  void enlarge();
  void clearSlots();
  void order(const HitColumns& hits);
  void sum(const HitColumns& hits, double cell, bool oneSided, std::size_t first, std::size_t last);
  void layOut();
  std::size_t placeOf(const std::int32_t* cell) const;
  std::int32_t* chainOf(const std::int32_t* cell);
  template <typename Visit>
  void eachNeighbour(const std::int32_t* cell, const Visit& visit);
  bool linked(std::size_t bin, std::size_t from, double weight, double close) const;
  void grow(std::size_t seed, Sums& patch, std::int32_t number, double close);

  // Of each hit: its cell and direction, how far it faces the other body, and its bin.
  std::vector<std::int32_t> cellX_, cellY_, cellZ_, direction_;
  std::vector<float> gate_;
  std::vector<std::uint32_t> bin_;

  std::vector<Bin> bins_;
  std::vector<Sums> sums_;           // of each bin
  std::vector<std::uint64_t> keys_;  // of each bin
  std::vector<std::int32_t> table_;  // a key's bin, open addressing, -1 empty
  std::size_t slots_ = 0;            // of it that are in use: the last pair's may have been many
  std::vector<std::int32_t> box_;    // a cell's first free bin, by place in their box or by hash
  std::size_t free_ = 0;             // bins that belong to no patch yet
  std::size_t cells_ = 0;            // of that box; 0 where it is hashed
  bool hashed_ = false;
  std::int32_t low_[3] = {}, span_[3] = {};
  std::vector<std::uint32_t> order_, queue_;  // order_: hits by bin, then bins by weight
  std::vector<HitRun> runs_;                  // of the bins, in their order
  std::vector<Sums> patches_;
};

}  // namespace cloudcontact
