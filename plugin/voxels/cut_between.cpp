// Compares two clouds brick by brick.
#include "voxels/cut_between.h"

#include "base/grid_index.h"

namespace cloudcontact {

namespace {

// Of stored numbers, or of codes.
template <typename Bricks>
bool same(const Bricks& a, std::int32_t i, const Bricks& b, std::int32_t k) {
  return i < 0 || k < 0 ? i == k : a[static_cast<std::size_t>(i)] == b[static_cast<std::size_t>(k)];
}

}  // namespace

bool sameCoverage(const Cloud::Voxels& a, const Cloud::Voxels& b, std::size_t brick) {
  return same(a.coverage, a.table[brick], b.coverage, b.table[brick]);
}

bool sameMaterial(const Cloud::Voxels& a, const Cloud::Voxels& b, std::size_t brick) {
  if (a.materialTable.empty() || b.materialTable.empty())
    return a.materialTable.empty() == b.materialTable.empty();
  return same(a.material, a.materialTable[brick], b.material, b.materialTable[brick]);
}

std::vector<VoxelCut> cutsBetween(const Cloud& before, const Cloud& after) {
  const Cloud::Voxels &a = before.voxels(), &b = after.voxels();
  std::vector<VoxelCut> cuts;
  for (std::size_t t = 0; t < a.table.size(); ++t) {
    if (sameCoverage(a, b, t)) continue;
    const Eigen::Vector3i low = kBrickEdge * gridCell(t, before.bricks());
    for (int k = 0; k < kBrickVoxels; ++k)
      if (const std::uint8_t left = coverageIn(b, b.table[t], k);
          left < coverageIn(a, a.table[t], k))
        cuts.push_back({low + cellOffset(k), left});
  }
  return cuts;
}

}  // namespace cloudcontact
