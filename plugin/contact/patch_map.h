// PatchMap: which patch a place belongs to. A patch is a set of bins (binner.h); a place belongs to
// a bin of its own cell or, if that has none, of a neighboring cell.
#pragma once

#include <cloudcontact/base/pose.h>

#include <array>
#include <cstdint>
#include <vector>

#include "contact/binner.h"

namespace cloudcontact {

class PatchMap {
 public:
  // `cell`: edge of a bin's cell [m], as given to the binner.
  void read(const std::vector<Binner::Bin>& bins, double cell);
  // The patch of a place in the pair's frame [m]; -1 if no bin is near. Of several bins in a cell,
  // the one whose normals on body `side` agree best with `normal` counts, or the heaviest one if
  // `normal` is zero.
  int of(const Vec3& place, int side, const Vec3& normal) const;

 private:
  using Cell = std::array<std::int32_t, 3>;
  struct Entry {
    Cell cell;
    const Binner::Bin* bin;
  };
  // The entries of a cell.
  struct Run {
    Cell cell;
    std::size_t first, last;
  };
  Run runOf(const Cell& cell) const;
  void consider(const Run& run, int side, const Vec3& normal, double& best, int& patch) const;

  std::vector<Entry> entries_;  // sorted by cell
  mutable Run latest_{};        // neighboring voxels mostly share a cell
  double perCell_ = 0;
};

}  // namespace cloudcontact
