// A cut body's field from the one before the cut. Each step of the builder (field_builder.h) looks
// but a few voxels far, so each is run again only on the voxels that see something changed:
//   fits     the block of 3x3x3 holds a voxel that was cut
//   edges    a face within 3 voxels changed in the pass before; where nothing comes of it, no more
//            voxels follow (field_edges.cpp)
//   samples  pieces changed in the voxel or beside it, or slivers that it takes in: two voxels
//            farther
//   band     pieces changed at most as far away as the band has layers
// Every other voxel would read what it read before, and so come to the same bits. What is left to
// do for all is to copy: the records and samples lie in one piece each, as queries want them.
#include "field/field_data.h"

#include <cstring>
#include <stdexcept>

namespace cloudcontact {

namespace {

const std::uint8_t* voxelsOf(const Cloud& cloud, std::size_t t) {
  static const auto kEven = [] {
    std::array<BrickCoverage, 2> two;
    two[0].fill(0);
    two[1].fill(255);
    return two;
  }();
  const std::int32_t b = cloud.voxels().table[t];
  if (b >= 0) return cloud.voxels().coverage[static_cast<std::size_t>(b)].data();
  return kEven[b == kSolidBrick ? 1 : 0].data();
}

// Voxels whose coverage is another.
VoxelSet changedVoxels(const Cloud& before, const Cloud& after) {
  VoxelSet changed(after.bricks());
  const Eigen::Vector3i n = after.bricks();
  for (std::size_t t = 0; t < after.voxels().table.size(); ++t) {
    const std::uint8_t *const a = voxelsOf(before, t), *const b = voxelsOf(after, t);
    if (a == b || std::memcmp(a, b, kBrickVoxels) == 0) continue;
    const int i = static_cast<int>(t);
    const Eigen::Vector3i low =
        kBrickEdge * Eigen::Vector3i(i % n.x(), i / n.x() % n.y(), i / n.x() / n.y());
    for (int k = 0; k < kBrickVoxels; ++k)
      if (a[k] != b[k]) changed.add(low.x() + (k & 7), low.y() + (k >> 3 & 7), low.z() + (k >> 6));
  }
  return changed;
}

void check(const SurfaceField* before, const Cloud& after) {
  if (!before) throw std::invalid_argument("renewed: there is no field to renew");
  if (after.empty()) throw std::invalid_argument("renewed: the cloud is empty");
  if (after.bricks() != before->cloud().bricks() ||
      after.voxelSize() != before->cloud().voxelSize())
    throw std::invalid_argument(
        "renewed: the cloud has another grid than the field's; build its field anew");
}

}  // namespace

std::shared_ptr<const SurfaceField> renewed(const std::shared_ptr<const SurfaceField>& before,
                                            const Cloud& after, const FieldSettings& settings) {
  check(before.get(), after);
  const FieldData& old = static_cast<const FieldData&>(*before);
  if (!old.notes()) {
    FieldSettings again = settings;
    again.renewable = true;
    return SurfaceField::build(after, again);
  }
  const VoxelSet cut = changedVoxels(old.cloud(), after);
  FieldDraft draft(after, settings, old.notes()->bricks);
  const VoxelSet refitted = cut.dilated(1);
  const VoxelSet changed =
      resolveEdgesAgain(draft, old.notes()->bricks, refitted, refitSurfaceVoxels(draft, refitted));
  draft.compact();
  if (draft.surfaceBricks().empty())
    throw std::invalid_argument("renewed: nothing of the body's surface is left");
  // Pieces within one voxel of a changed one may have other areas; a voxel's slivers are shared out
  // among what lies within one voxel of them.
  VoxelSet sampled = changed.dilated(3);
  sampled.add(cut.dilated(2));
  auto notes = std::make_shared<FieldNotes>();
  FieldData::Parts parts;
  parts.samples = renewSamples(old.samples(), old.notes()->origins, sampled,
                               cutSamples(draft, &sampled), notes->origins);
  VoxelSet reached = changed.dilated(1);
  reached.add(cut);
  parts.band = spreadBandAgain(draft, reached.dilated(kBandReach), old);
  notes->bricks = draft.bricks();
  parts.notes = std::move(notes);
  parts.before = &old;
  return std::make_shared<FieldData>(after, std::move(parts));
}

}  // namespace cloudcontact
