// Surface voxels of a brick, and the draft's bricks: shared with an earlier field until written to.
#include "field/field_draft.h"

#include <cstring>

namespace cloudcontact {

static_assert(sizeof(CcSurface) == 15 * sizeof(float), "no padding: same() compares bytes");

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
  passes = static_cast<std::uint16_t>(passes | 1 << step.pass);
  return static_cast<std::int16_t>(steps.size() - 1);
}

void SurfaceBrick::findPlaces() {
  place.fill(-1);
  for (std::size_t i = 0; i < voxels.size(); ++i)
    place[static_cast<std::size_t>(voxels[i].cell)] = static_cast<std::int16_t>(i);
}

void SurfaceBrick::compact() {
  SurfaceBrick result;
  for (const SurfaceVoxel& v : voxels) {
    std::vector<int> chain;
    for (int s = v.last; s >= 0; s = steps[static_cast<std::size_t>(s)].earlier) chain.push_back(s);
    std::int16_t last = -1;
    for (std::size_t i = chain.size(); i-- > 0;) {
      const VoxelState old = stateAt(chain[i]);
      VoxelStep step = *old.step;
      step.earlier = last;
      last = result.addStep(step);
      for (int k = 0; k < step.count; ++k)
        result.pieces[result.steps.back().first + static_cast<std::uint32_t>(k)] = old.pieces[k];
    }
    result.voxels.push_back({v.cell, last});
  }
  result.findPlaces();
  *this = std::move(result);
}

FieldDraft::FieldDraft(const Cloud& wholeCloud, int threadsUsed,
                       const std::function<void(double)>& spendOfSettings, SurfaceBricks before)
    : cloud(wholeCloud),
      threads(threadsUsed),
      spend_(spendOfSettings),
      size_(cloud.bricks()),
      bricks_(std::move(before)),
      own_(cloud.voxels().table.size(), nullptr) {
  bricks_.resize(own_.size());
}

SurfaceBrick& FieldDraft::write(std::size_t t) {
  if (!own_[t]) {
    auto brick =
        bricks_[t] ? std::make_shared<SurfaceBrick>(*bricks_[t]) : std::make_shared<SurfaceBrick>();
    own_[t] = brick.get();
    bricks_[t] = std::move(brick);
  }
  return *own_[t];
}

void FieldDraft::compact() {
  for (std::size_t t = 0; t < own_.size(); ++t) {
    if (!own_[t]) continue;
    own_[t]->compact();
    if (!own_[t]->voxels.empty()) continue;
    own_[t] = nullptr;
    bricks_[t] = nullptr;
  }
}

std::vector<std::int32_t> FieldDraft::surfaceBricks() const {
  std::vector<std::int32_t> numbers;
  for (std::size_t t = 0; t < bricks_.size(); ++t)
    if (bricks_[t] && !bricks_[t]->voxels.empty()) numbers.push_back(static_cast<std::int32_t>(t));
  return numbers;
}

Eigen::Vector3i FieldDraft::cornerOf(std::size_t t) const {
  return kBrickEdge * gridCell(t, size_);
}

DraftVoxel FieldDraft::voxelAt(std::int32_t brick, int cell) const {
  const Eigen::Vector3i at = cornerOf(static_cast<std::size_t>(brick)) + cellOffset(cell);
  return {brick, static_cast<std::int16_t>(cell), at.x(), at.y(), at.z()};
}

DraftVoxel FieldDraft::voxelAt(int x, int y, int z) const {
  return {static_cast<std::int32_t>(brickIndex(x, y, z, size_)),
          static_cast<std::int16_t>(cellIndex(x, y, z)), x, y, z};
}

}  // namespace cloudcontact
