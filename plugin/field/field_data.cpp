// Size, bounds and hash of a field's data.
#include "field/field_data.h"

#include "base/hash.h"

#include <algorithm>
#include <array>

namespace cloudcontact {

namespace {

// A hash of arrays, each after its length.
class Hasher {
 public:
  template <typename T>
  void add(const T* first, std::size_t count) {
    hash_.mix(count);
    hash_.add(first, count * sizeof(T));
  }
  std::uint64_t value() const { return hash_.value(); }

 private:
  WordHash hash_;
};

// Least and largest of some values, in lanes.
std::pair<float, float> range(const LargeVector<float>& v) {
  constexpr std::size_t kLanes = 16;
  float least[kLanes], most[kLanes];
  std::fill(least, least + kLanes, v[0]);
  std::fill(most, most + kLanes, v[0]);
  for (std::size_t k = 0; k + kLanes <= v.size(); k += kLanes)
    for (std::size_t i = 0; i < kLanes; ++i) {
      least[i] = v[k + i] < least[i] ? v[k + i] : least[i];
      most[i] = v[k + i] > most[i] ? v[k + i] : most[i];
    }
  for (std::size_t k = v.size() / kLanes * kLanes; k < v.size(); ++k) {
    least[0] = std::min(least[0], v[k]);
    most[0] = std::max(most[0], v[k]);
  }
  return {*std::min_element(least, least + kLanes), *std::max_element(most, most + kLanes)};
}

}  // namespace

FieldData::FieldData(Cloud cloud, const Band& band, SampleSet samples,
                     std::shared_ptr<const FieldNotes> notes, const FieldData& before)
    : FieldData(cloud, FieldRecords(cloud, band, &before.records_), std::move(samples),
                std::move(notes)) {
  renewed_ = true;
}

FieldData::FieldData(Cloud cloud, FieldRecords records, SampleSet samples,
                     std::shared_ptr<const FieldNotes> notes)
    : cloud_(std::move(cloud)),
      records_(std::move(records)),
      samples_(std::move(samples)),
      notes_(std::move(notes)) {
  const SampleColumns& all = samples_.levels[0].samples;
  if (all.size() == 0) return;
  const auto x = range(all.x), y = range(all.y), z = range(all.z);
  bounds_.extend(cloud_.origin() + cloud_.voxelSize() * Vec3(x.first, y.first, z.first));
  bounds_.extend(cloud_.origin() + cloud_.voxelSize() * Vec3(x.second, y.second, z.second));
}

std::size_t FieldData::bytes() const {
  std::size_t sum = records_.bytes() + samples_.bytes();
  if (!notes_) return sum;
  sum += notes_->origins.size() * sizeof(SampleOrigin) + notes_->edges.bytes();
  for (const auto& cells : notes_->layers)
    if (cells) sum += sizeof(BandCells);
  for (const auto& brick : notes_->bricks)
    if (brick)
      sum += sizeof(SurfaceBrick) + brick->voxels.size() * sizeof(SurfaceVoxel) +
             brick->steps.size() * sizeof(VoxelStep) + brick->pieces.size() * sizeof(SurfacePiece);
  return sum;
}

// Adds the records of a brick but for what only spares lookups, which renewed fields do not have:
// bends, and what is known of voxels outside.
static void addBrick(const CcVoxel* brick, Hasher& hasher) {
  std::array<CcVoxel, kBrickVoxels> plain;
  std::copy_n(brick, kBrickVoxels, plain.begin());
  for (CcVoxel& v : plain) {
    const bool outside = ccPlaneCount(v) == 0 && v.b != CC_DEEP_INSIDE;
    outside ? void(v = {0, 0}) : ccSetBend(&v, 0);
  }
  const bool same = std::all_of(plain.begin(), plain.end(), [&](const CcVoxel& v) {
    return v.a == plain[0].a && v.b == plain[0].b;
  });
  hasher.add(plain.data(), same ? 1 : plain.size());
}

// Over all data that queries read.
std::uint64_t FieldData::hash() const {
  Hasher hasher;
  const std::size_t bricks = brickDistance().size();
  for (std::size_t t = 0; t < bricks; ++t) addBrick(records_.brick(t), hasher);
  hasher.add(records_.between(), bricks);
  hasher.add(planes(), planeCount());
  hasher.add(brickDistance().data(), bricks);
  for (const SampleLevel& level : samples_.levels) {
    const SampleColumns& s = level.samples;
    for (const auto* column : {&s.x, &s.y, &s.z, &s.nx, &s.ny, &s.nz, &s.area, &s.width})
      hasher.add(column->data(), column->size());
    hasher.add(level.clusters.rise.data(), level.clusters.size());
    for (const auto& column : level.clusters.spread) hasher.add(column.data(), column.size());
    hasher.add(level.cellOf.data(), level.cellOf.size());
    hasher.add(level.finer.data(), level.finer.size());
  }
  const SampleBricks& b = samples_.bricks;
  for (const auto* column : {&b.x, &b.y, &b.z, &b.radius})
    hasher.add(column->data(), column->size());
  hasher.add(b.runs.data(), b.runs.size());
  for (int axis = 0; axis < 3; ++axis) {
    hasher.add(&bounds_.min()[axis], 1);
    hasher.add(&bounds_.max()[axis], 1);
  }
  return hasher.value();
}

}  // namespace cloudcontact
