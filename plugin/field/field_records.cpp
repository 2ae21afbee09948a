// Records for every brick: the band's own, or constant ones that depend on what fills the brick and
// where the band is near.
#include "field/field_records.h"

#include "base/grid_index.h"

#include <algorithm>
#include <map>

namespace cloudcontact {

namespace {

int blockOf(int cell) {
  return (cell >> 2 & 1) | (cell >> 4 & 2) | (cell >> 6 & 4);
}

// Chebyshev distance transform over the table of bricks, 0 where `distance` is 0 at first.
std::vector<std::uint8_t> distanceToBand(const Eigen::Vector3i& n,
                                         std::vector<std::uint8_t> distance) {
  for (int axis = 0; axis < 3; ++axis) {
    // Per axis: d(x) = min over y of max(d(y), |x - y|).
    std::vector<std::uint8_t> line(static_cast<std::size_t>(n[axis]));
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    for (int j = 0; j < n[b]; ++j)
      for (int i = 0; i < n[a]; ++i) {
        Eigen::Vector3i at;
        at[a] = i;
        at[b] = j;
        for (int k = 0; k < n[axis]; ++k) {
          at[axis] = k;
          line[static_cast<std::size_t>(k)] = distance[gridIndex(at, n)];
        }
        for (int k = 0; k < n[axis]; ++k) {
          int best = 255;
          for (int r = 0; r < best && r < n[axis]; ++r)
            for (int side : {-r, r})
              if (k + side >= 0 && k + side < n[axis])
                best = std::min(
                    best, std::max(r, static_cast<int>(line[static_cast<std::size_t>(k + side)])));
          at[axis] = k;
          distance[gridIndex(at, n)] = static_cast<std::uint8_t>(best);
        }
      }
  }
  return distance;
}

}  // namespace

// The bricks of a band: new ones, and those of an earlier field.
class FieldRecords::Source {
 public:
  Source(const Band& band, const FieldRecords* before) : band_(band), before_(before) {}

  std::size_t size() const { return band_.table.size(); }
  BandView view(std::size_t brick) const {
    const std::int32_t slot = band_.table[brick];
    if (slot == kNoBand) return {};
    if (slot == kAsBefore) return before_->bandBrick(brick);
    const BandBrick& b = band_.bricks[static_cast<std::size_t>(slot)];
    return {b.cells.data(), b.planes.data(), static_cast<std::uint32_t>(b.planes.size()), 0};
  }
  // As FieldRecords::held().
  std::uint8_t held(std::size_t brick) const {
    if (band_.table[brick] == kAsBefore) return before_->held_[brick];
    const BandView b = view(brick);
    int mask = 0;
    for (int k = 0; k < kBrickVoxels && b.cells; ++k)
      if (ccPlaneCount(b.cells[k]) > 0) mask |= 1 << blockOf(k);
    return static_cast<std::uint8_t>(mask);
  }
  // About as many planes as there will be.
  std::size_t planes() const { return before_ ? before_->planes_.size() * 9 / 8 : 0; }
  // True if a brick's records are those of the earlier field.
  bool copies(std::size_t brick, std::uint32_t firstPlane, std::uint8_t near) const {
    if (band_.table[brick] != kAsBefore || before_->near_[brick] != near) return false;
    const BandView b = view(brick);
    return b.planeCount == 0 || b.first == firstPlane;
  }
  std::int16_t planed(std::size_t brick) const { return before_->planed_[brick]; }
  // As FieldRecords::brickDistance(). Those of the earlier field hold if the band has the same
  // bricks.
  std::vector<std::uint8_t> distances(const Cloud& cloud) const {
    std::vector<std::uint8_t> inBand(size());
    bool same = before_ != nullptr;
    for (std::size_t t = 0; t < inBand.size(); ++t) {
      inBand[t] = view(t).cells ? 0 : 255;
      same = same && (inBand[t] == 0) == (before_->distance_[t] == 0);
    }
    return same ? before_->distance_ : distanceToBand(cloud.bricks(), std::move(inBand));
  }

 private:
  const Band& band_;
  const FieldRecords* before_;
};

struct FieldRecords::Builder {
  const Cloud& cloud;
  const std::vector<std::uint32_t>& planeFirsts;
  const std::vector<std::uint8_t>& held;
  std::vector<std::uint8_t>& near;       // FieldRecords::near_
  std::map<int, std::int32_t> constant;  // first record of the constant bricks, by kind

  Eigen::Vector3i brickAt(std::size_t t) const { return gridCell(t, cloud.bricks()); }
  bool inside(const Eigen::Vector3i& low, int cell) const {
    const Eigen::Vector3i v = low + cellOffset(cell);
    return cloud.coverage(v.x(), v.y(), v.z()) > 127;
  }

  // Marks blocks that hold band voxels, and their 26 neighbors, axis by axis.
  void markNear() {
    near = held;
    const Eigen::Vector3i n = cloud.bricks();
    for (int axis = 0; axis < 3; ++axis) {
      const std::vector<std::uint8_t> from = near;
      const int bit = 1 << axis;                                   // from a low block to a high one
      const int low = axis == 0 ? 0x55 : axis == 1 ? 0x33 : 0x0f;  // the blocks on the low side
      const std::size_t stride = gridIndex(Eigen::Vector3i::Unit(axis), n);
      for (std::size_t t = 0; t < near.size(); ++t) {
        const int own = from[t];
        if (own == 0) continue;
        near[t] = static_cast<std::uint8_t>(near[t] | (own & low) << bit | (own & ~low) >> bit);
        const int at = brickAt(t)[axis];
        if (at > 0)
          near[t - stride] = static_cast<std::uint8_t>(near[t - stride] | (own & low) << bit);
        if (at + 1 < n[axis])
          near[t + stride] =
              static_cast<std::uint8_t>(near[t + stride] | (own & ~low & 0xff) >> bit);
      }
    }
  }

  CcVoxel plainRecord(const Eigen::Vector3i& low, int cell, int mask) const {
    if (inside(low, cell)) return {0, CC_DEEP_INSIDE};
    return {0, mask >> blockOf(cell) & 1 ? CC_NEAR_OUTSIDE : 0};
  }

  // Records of a brick without planes. Its own if it is partly inside, otherwise shared.
  std::int32_t plainBrick(std::size_t t, LargeVector<CcVoxel>& records, bool& solid) {
    const Eigen::Vector3i low = brickAt(t) * kBrickEdge;
    const std::int32_t stored = cloud.voxels().table[t];
    int full = stored == kSolidBrick ? kBrickVoxels : 0;
    if (stored >= 0)
      for (int k = 0; k < kBrickVoxels; ++k) full += inside(low, k);
    solid = full > 0;
    const bool mixed = full > 0 && full < kBrickVoxels;
    const int kind = full == kBrickVoxels ? 256 : near[t];
    if (!mixed)
      if (const auto known = constant.find(kind); known != constant.end()) return known->second;
    const std::int32_t first = static_cast<std::int32_t>(records.size());
    for (int k = 0; k < kBrickVoxels; ++k) records.push_back(plainRecord(low, k, near[t]));
    if (!mixed) constant[kind] = first;
    return first;
  }

  // Appends the records of a brick with planes. Renumbers the planes and marks near-outside voxels
  // again, since these depend on neighboring bricks. Returns the number of band voxels.
  std::int16_t addBandBrick(std::size_t t, const BandView& brick,
                            LargeVector<CcVoxel>& records) const {
    const std::size_t first = records.size();
    records.insert(records.end(), brick.cells, brick.cells + kBrickVoxels);
    const std::uint32_t shift = planeFirsts[t] - brick.first;
    std::int16_t bandVoxels = 0;
    for (int k = 0; k < kBrickVoxels; ++k) {
      CcVoxel& v = records[first + static_cast<std::size_t>(k)];
      const uint count = ccPlaneCount(v);
      bandVoxels = static_cast<std::int16_t>(bandVoxels + (count > 0));
      if (count > 1)
        v.b += shift;
      else if (count == 0 && v.b != CC_DEEP_INSIDE)
        v.b = near[t] >> blockOf(k) & 1 ? CC_NEAR_OUTSIDE : 0;
    }
    return bandVoxels;
  }
};

FieldRecords::FieldRecords(const Cloud& cloud, const Band& band, const FieldRecords* before)
    : FieldRecords(cloud, Source(band, before)) {}

FieldRecords::FieldRecords(const Cloud& cloud, const Source& source)
    : distance_(source.distances(cloud)) {
  const std::size_t all = source.size();
  std::size_t bandBricks = 0;
  planeFirsts_.reserve(all + 1);
  held_.reserve(all);
  planes_.reserve(source.planes());
  for (std::size_t t = 0; t < all; ++t) {
    const BandView brick = source.view(t);
    planeFirsts_.push_back(static_cast<std::uint32_t>(planes_.size()));
    planes_.insert(planes_.end(), brick.planes, brick.planes + brick.planeCount);
    held_.push_back(source.held(t));
    bandBricks += held_.back() > 0;
  }
  planeFirsts_.push_back(static_cast<std::uint32_t>(planes_.size()));
  Builder builder{cloud, planeFirsts_, held_, near_, {}};
  builder.markNear();
  planed_.assign(all, 0);
  const Eigen::Vector3i n = cloud.bricks();
  bricks_ = {n.x(), n.y(), n.z()};
  firsts_.reserve(all + 1);
  between_.reserve(all);
  records_.reserve((bandBricks + 8) * kBrickVoxels);
  records_.assign(kBrickVoxels, CcVoxel{0, 0});  // the outside
  for (std::size_t t = 0; t < all; ++t) {
    bool solid = false;
    if (held_[t]) {
      const BandView brick = source.view(t);
      firsts_.push_back(static_cast<std::int32_t>(records_.size()));
      if (source.copies(t, planeFirsts_[t], near_[t])) {
        records_.insert(records_.end(), brick.cells, brick.cells + kBrickVoxels);
        planed_[t] = source.planed(t);
      } else {
        planed_[t] = builder.addBandBrick(t, brick, records_);
      }
      bandVoxels_ += static_cast<std::size_t>(planed_[t]);
    } else {
      firsts_.push_back(builder.plainBrick(t, records_, solid));
    }
    // At a Chebyshev distance of n bricks there are at least n - 1 whole bricks between.
    between_.push_back(solid ? -kBrickEdge : (static_cast<int>(distance_[t]) - 1) * kBrickEdge);
  }
  firsts_.push_back(0);
}

BandView FieldRecords::bandBrick(std::size_t brick) const {
  if (distance_[brick] > 0) return {};
  const std::uint32_t first = planeFirsts_[brick];
  return {records_.data() + firsts_[brick], planes_.data() + first, planeFirsts_[brick + 1] - first,
          first};
}

void FieldRecords::setBrick(std::size_t brick, const std::array<CcVoxel, kBrickVoxels>& records) {
  firsts_[brick] = static_cast<std::int32_t>(records_.size());
  records_.insert(records_.end(), records.begin(), records.end());
}

bool FieldRecords::complete(const Eigen::Vector3i& bricks, std::size_t bandVoxels) {
  bricks_ = {bricks.x(), bricks.y(), bricks.z()};
  bandVoxels_ = bandVoxels;
  const std::size_t all = between_.size();
  const auto inside = [&](std::int32_t first) {
    return first >= 0 && static_cast<std::size_t>(first) + kBrickVoxels <= records_.size();
  };
  const auto hasItsPlanes = [&](CcVoxel v) {
    const uint count = ccPlaneCount(v);
    return count < 2 ||
           (count <= CC_MAX_PLANES && v.b < planes_.size() && count <= planes_.size() - v.b);
  };
  return all == static_cast<std::size_t>(bricks.cast<std::int64_t>().prod()) &&
         distance_.size() == all && held_.size() == all && near_.size() == all &&
         planed_.size() == all && firsts_.size() == all + 1 && planeFirsts_.size() == all + 1 &&
         planeFirsts_.back() == planes_.size() &&
         std::is_sorted(planeFirsts_.begin(), planeFirsts_.end()) &&
         std::all_of(firsts_.begin(), firsts_.end(), inside) &&
         std::all_of(records_.begin(), records_.end(), hasItsPlanes);
}

std::size_t FieldRecords::bytes() const {
  return (records_.size() + planes_.size()) * sizeof(CcVoxel) +
         (firsts_.size() + between_.size()) * sizeof(std::int32_t) +
         planeFirsts_.size() * sizeof(std::uint32_t) + held_.size() + near_.size() +
         planed_.size() * sizeof(std::int16_t) + distance_.size();
}

}  // namespace cloudcontact
