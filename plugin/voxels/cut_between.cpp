// Compares two clouds brick by brick.
#include "voxels/cut_between.h"

#include "base/grid_index.h"

namespace cloudcontact {

std::vector<VoxelCut> cutsBetween(const Cloud& before, const Cloud& after) {
  const Cloud::Voxels &a = before.voxels(), &b = after.voxels();
  const auto coverage = [](const Cloud::Voxels& v, std::int32_t brick, std::size_t cell) {
    return brick == kEmptyBrick   ? std::uint8_t{0}
           : brick == kSolidBrick ? std::uint8_t{255}
                                  : v.coverage[static_cast<std::size_t>(brick)][cell];
  };
  std::vector<VoxelCut> cuts;
  for (std::size_t t = 0; t < a.table.size(); ++t) {
    const std::int32_t old = a.table[t], now = b.table[t];
    if (old == kEmptyBrick || (old == now && old < 0)) continue;
    for (std::size_t k = 0; k < kBrickVoxels; ++k) {
      const std::uint8_t left = coverage(b, now, k);
      if (left < coverage(a, old, k))
        cuts.push_back(
            {kBrickEdge * gridCell(t, before.bricks()) + cellOffset(static_cast<int>(k)), left});
    }
  }
  return cuts;
}

}  // namespace cloudcontact
