// States and steps of a brick's surface voxels.
#include "field/surface_brick.h"

#include <cstring>

namespace cloudcontact {

static_assert(sizeof(CcSurface) == 15 * sizeof(float), "compared byte by byte: no padding");

bool same(const VoxelState& a, const VoxelState& b) {
  if (!a || !b) return !a && !b;
  if (a.step->pass != b.step->pass || a.rule() != b.rule() || a.count() != b.count()) return false;
  for (int k = 0; k < a.count(); ++k)
    if (std::memcmp(&a.pieces[k].surface, &b.pieces[k].surface, sizeof(CcSurface)) != 0)
      return false;
  return true;
}

std::int16_t SurfaceBrick::addStep(VoxelStep step) {
  step.first = static_cast<std::uint32_t>(pieces.size());
  pieces.resize(pieces.size() + step.count);
  steps.push_back(step);
  return static_cast<std::int16_t>(steps.size() - 1);
}

void SurfaceBrick::findPlaces() {
  place.fill(-1);
  for (std::size_t i = 0; i < voxels.size(); ++i)
    place[static_cast<std::size_t>(voxels[i].cell)] = static_cast<std::int16_t>(i);
}

void SurfaceBrick::compact() {
  SurfaceBrick tidy;
  for (const SurfaceVoxel& v : voxels) {
    std::vector<int> chain;
    for (int s = v.last; s >= 0; s = steps[static_cast<std::size_t>(s)].earlier) chain.push_back(s);
    std::int16_t last = -1;
    for (std::size_t i = chain.size(); i-- > 0;) {
      const VoxelState old = stateAt(chain[i]);
      VoxelStep step = *old.step;
      step.earlier = last;
      last = tidy.addStep(step);
      for (int k = 0; k < step.count; ++k)
        tidy.pieces[tidy.steps.back().first + static_cast<std::uint32_t>(k)] = old.pieces[k];
    }
    tidy.voxels.push_back({v.cell, last});
  }
  tidy.findPlaces();
  *this = std::move(tidy);
}

}  // namespace cloudcontact
