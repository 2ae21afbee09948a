// Groups hits into bins, one for each cell of 8 voxels and each of six directions, and grows bins
// into patches by region growing (docs/force.md, "Bins", "Growing patches").
#pragma once

#include <cloudcontact/base/task_runner.h>

#include "contact/sums.h"

#include <cstdint>
#include <span>
#include <vector>

namespace cloudcontact {

// Groups hits into patches. It keeps its memory between calls.
class Binner {
 public:
  struct Bin {
    std::int32_t cell[3];
    std::int32_t next = -1;   // next free bin of the same cell; -1: none
    std::int32_t patch = -1;  // index into patches()
    std::uint32_t end = 0;    // of its hits in order_
    std::size_t run = 0;      // its first in runs_
    double weight = 0;        // sizes of both sides' pushes
    CcFaces faces = {};
  };

  // Returns the sums of each patch, in a fixed order. `cell`: edge of a bin's cell [m]. `oneSided`:
  // the other body is a shape, so each hit also stands for the shape's surface. `gated`: hits count
  // as far as they face the other body; else all alike, if any is in it. With `runner` the sums
  // over many hits run in parallel; the bits are the same.
  const std::vector<CcSums>& patches(const HitColumns& hits, double cell, bool oneSided,
                                     bool gated = true, const TaskRunner* runner = nullptr);
  // Those of the last call.
  const std::vector<CcSums>& patches() const { return patches_; }
  // The bins of the last patches(), in a fixed order, and their sums.
  const std::vector<Bin>& bins() const { return bins_; }
  const CcSums& sums(std::uint32_t bin) const { return sums_[bin]; }
  // The hits of a bin, in the order of their sums.
  std::span<const std::uint32_t> hitsOf(std::uint32_t bin) const {
    const std::uint32_t begin = bin > 0 ? bins_[bin - 1].end : 0;
    return {order_.data() + begin, bins_[bin].end - begin};
  }
  // The patch of a hit.
  std::size_t patchOf(std::size_t hit) const {
    return static_cast<std::size_t>(bins_[bin_[hit]].patch);
  }
  // The patch of a bin, or of the bin nearest to where that would be, with whose surface of body
  // `side` the normal `own` agrees best. There must be hits.
  std::size_t patchNear(const CcBinOfHit& bin, int side, const float* own) const;
  // The bins of a patch, in the order in which they joined.
  std::span<const std::uint32_t> binsOf(std::size_t patch) const {
    const std::uint32_t begin = patch > 0 ? ends_[patch - 1] : 0;
    return {queue_.data() + begin, ends_[patch] - begin};
  }
  // Reserves what `other` has reserved.
  void reserveLike(const Binner& other);

 private:
  void findBins(const HitColumns& hits, double cell);
  // Hits count alike, however they face the other body, if any sample lies in it; else not at all.
  void openGates(const HitColumns& hits);
  void findBox(int count);
  void findPlaces(int count);
  void addTo(std::uint32_t bin, std::size_t hit);
  std::uint32_t binOf(std::uint64_t key);
  void enlarge();
  void clearSlots();
  void order(const HitColumns& hits);
  void sum(const HitColumns& hits, double cell, bool oneSided, std::size_t first, std::size_t last);
  void layOut();
  const Bin* find(const CcBinOfHit& bin) const;
  std::size_t placeOf(const std::int32_t* cell) const;
  std::int32_t* chainOf(const std::int32_t* cell);
  template <typename Visit>
  void eachNeighbor(const std::int32_t* cell, const Visit& visit);
  bool linked(std::size_t bin, std::size_t from, double weight, double close) const;
  void grow(std::size_t seed, CcSums& patch, std::int32_t number, double close);

  // For each hit: its cell, its direction, how far it faces the other body, and its bin.
  std::vector<std::int32_t> cellX_, cellY_, cellZ_, direction_;
  std::vector<float> gate_;
  std::vector<std::uint32_t> bin_;

  std::vector<Bin> bins_;
  std::vector<CcSums> sums_;         // of each bin
  std::vector<std::uint64_t> keys_;  // of each bin
  std::vector<std::int32_t> table_;  // bin of a key; open addressing, -1: empty
  std::size_t slots_ = 0;            // part of table_ in use
  std::vector<std::int32_t> box_;    // first free bin of a cell, by place in the box or by hash
  std::size_t free_ = 0;             // bins without a patch
  std::size_t cells_ = 0;            // of the box; 0 if hashed
  bool hashed_ = false;
  bool direct_ = false;  // table_ is addressed by cell and direction
  std::int32_t low_[3] = {}, span_[3] = {};
  std::vector<std::uint32_t> order_;     // hits by bin
  std::vector<std::uint32_t> heaviest_;  // bins by weight
  std::vector<std::uint32_t> queue_;     // bins by patch
  std::vector<std::uint32_t> ends_;      // of each patch, in queue_
  std::vector<HitRun> runs_;             // in the order of the bins
  std::vector<CcSums> patches_;
};

}  // namespace cloudcontact
