// Marks of waiting searches, in bricks.
#include "field/edge_queue.h"

namespace cloudcontact {

void EdgeQueue::add(const DraftVoxel& v, int passes) {
  if (passes == 0) return;
  Mark& mark = marks_.make(v.x, v.y, v.z);
  if (mark.passes == 0) {
    ++voxels_;
    mark.fresh = 0;
  }
  mark.passes = static_cast<std::uint16_t>(mark.passes | passes);
}

void EdgeQueue::addFresh(const DraftVoxel& v, int passes) {
  add(v, passes);
  marks_.make(v.x, v.y, v.z).fresh = renewal_;
}

void EdgeQueue::done(const DraftVoxel& v, int passes) {
  if (this->passes(v) == 0) return;
  Mark& mark = marks_.make(v.x, v.y, v.z);
  mark.passes = static_cast<std::uint16_t>(mark.passes & ~passes);
  if (mark.passes > 0) return;
  --voxels_;
  freeIfEmpty();
}

void EdgeQueue::drop(std::int32_t brick) {
  const std::int32_t slot = marks_.table()[static_cast<std::size_t>(brick)];
  if (slot < 0) return;
  for (Mark& mark : marks_.cells()[static_cast<std::size_t>(slot)]) {
    if (mark.passes > 0) --voxels_;
    mark = Mark{};
  }
  freeIfEmpty();
}

// The last voxel frees the bricks.
void EdgeQueue::freeIfEmpty() {
  if (voxels_ == 0) marks_ = BrickGrid<Mark>(marks_.bricks(), Mark{});
}

std::vector<DraftVoxel> EdgeQueue::waiting(const FieldDraft& draft, int rest) const {
  std::vector<DraftVoxel> found;
  const std::vector<std::int32_t>& table = marks_.table();
  for (std::size_t t = 0; t < table.size(); ++t) {
    if (table[t] < 0) continue;
    const auto& marks = marks_.cells()[static_cast<std::size_t>(table[t])];
    for (int k = 0; k < kBrickVoxels; ++k) {
      const Mark& mark = marks[static_cast<std::size_t>(k)];
      if (mark.passes == 0) continue;
      if (mark.fresh > 0 && renewal_ < mark.fresh + static_cast<std::uint32_t>(rest)) continue;
      found.push_back(draft.voxelAt(static_cast<std::int32_t>(t), k));
    }
  }
  return found;
}

}  // namespace cloudcontact
