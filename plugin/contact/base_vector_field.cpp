// Builds a field of base vectors, and reads it. The sums are the same integers whichever way they
// come about: gathered from a window's voxels when the field is built, or changed one by one by
// what is cut (base_vector_cut.cpp).
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "../geometry/parallel.h"
#include "field_bricks.h"

namespace cloudcontact {

namespace {

using Bricks = BaseVectorField::Bricks;

CcTap tapOf(const WindowTap& t) {
  return {t.weight, t.moment[0], t.moment[1], t.moment[2]};
}

// The window turned round, as rows.
void makeRows(Bricks& f) {
  const auto zeros = [&] {
    f.taps.insert(f.taps.end(), kBrickEdge, CcMoments{});
    f.weights.insert(f.weights.end(), kBrickEdge, 0.0);
  };
  zeros();
  for (auto t = f.window.taps.rbegin(); t != f.window.taps.rend(); ++t) {
    const bool goesOn = !f.rows.empty() && f.rows.back().y == -t->y && f.rows.back().z == -t->z &&
                        f.rows.back().x + static_cast<int>(f.rows.back().count) == -t->x;
    if (!goesOn) {
      if (!f.rows.empty()) zeros();
      f.rows.push_back({-t->x, -t->y, -t->z, static_cast<std::uint32_t>(f.taps.size()), 0});
    }
    ++f.rows.back().count;
    f.taps.push_back({static_cast<CcSum>(t->weight), static_cast<CcSum>(t->moment[0]),
                      static_cast<CcSum>(t->moment[1]), static_cast<CcSum>(t->moment[2])});
    f.weights.push_back(t->weight);
  }
  zeros();
}

void fillTissues(Bricks& f, const Cloud& cloud, const TissueTable& tissues) {
  const std::size_t kinds = std::max<std::size_t>(cloud.materials().size(), 1);
  requireTissues(tissues);
  if (tissues.size() != kinds)
    throw std::invalid_argument("BaseVectorField: the cloud has " + std::to_string(kinds) +
                                " materials, " + std::to_string(tissues.size()) +
                                " tissues were given (tissuesOf() finds them by name)");
  f.tissues = tissues;
  f.names = cloud.materials();
  double densest = 0;
  for (const Tissue& t : tissues) densest = std::max(densest, t.density);
  for (const Tissue& t : tissues)
    f.density.push_back(
        std::max(1, static_cast<int>(std::lround(CC_DENSEST * t.density / densest))));
  f.sums.resize(kinds);
}

// What a brick of the cloud holds, in one number: a tissue where it is full of that alone.
constexpr int kMixed = -1, kVoid = -2;
std::vector<int> kindsOf(const Cloud& cloud) {
  const Cloud::Voxels& v = cloud.voxels();
  std::vector<int> kinds(v.table.size(), kMixed);
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    if (v.table[k] == kEmptyBrick) kinds[k] = kVoid;
    if (v.table[k] == kSolidBrick)
      kinds[k] = v.materialTable.empty()  ? 0
                 : v.materialTable[k] < 0 ? -1 - v.materialTable[k]
                                          : kMixed;
  }
  return kinds;
}

// The tissue of a brick all of whose windows are full of it, or kMixed.
int deepInside(const Bricks& f, const std::vector<int>& kinds, const Eigen::Vector3i& brick) {
  const auto brickOf = [](const Eigen::Vector3i& v) {
    return Eigen::Vector3i(v.unaryExpr([](int x) { return x >> 3; }));
  };
  const Eigen::Vector3i corner = kBrickEdge * brick;
  const Eigen::Vector3i low = brickOf(corner + f.window.low.cwiseMin(0));
  const Eigen::Vector3i high =
      brickOf(corner + Eigen::Vector3i::Constant(kBrickEdge - 1) + f.window.high.cwiseMax(0));
  if ((low.array() < 0).any() || (high.array() >= f.bricks.array()).any()) return kMixed;
  const auto kind = [&](int x, int y, int z) {
    return kinds[static_cast<std::size_t>(x) +
                 static_cast<std::size_t>(f.bricks.x()) *
                     (static_cast<std::size_t>(y) +
                      static_cast<std::size_t>(f.bricks.y()) * static_cast<std::size_t>(z))];
  };
  const int own = kind(brick.x(), brick.y(), brick.z());
  if (own < 0) return kMixed;
  for (int z = low.z(); z <= high.z(); ++z)
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x)
        if (kind(x, y, z) != own) return kMixed;
  return own;
}

// Sums of one voxel, gathered from the cloud.
void gather(const Bricks& f, const Cloud& cloud, const VoxelIndex& v, FieldBlock& block, int cell) {
  CcMoments moments{};
  CcSum volume = 0;
  for (const WindowTap& t : f.window.taps) {
    const VoxelIndex at = v + VoxelIndex(t.x, t.y, t.z);
    const int coverage = cloud.coverage(at.x(), at.y(), at.z());
    if (coverage == 0) continue;
    const int tissue = f.names.empty() ? 0 : cloud.material(at.x(), at.y(), at.z());
    ccWeigh(&moments, tapOf(t), coverage * f.density[static_cast<std::size_t>(tissue)]);
    volume += static_cast<CcSum>(coverage * t.weight);
  }
  block.moments[static_cast<std::size_t>(cell)] = moments;
  block.volume[static_cast<std::size_t>(cell)] = volume;
}

void fillShared(Bricks& f) {
  for (std::size_t tissue = 0; tissue < f.tissues.size(); ++tissue) {
    FieldBlock& block = f.blocks[tissue];
    CcMoments moments{};
    CcSum volume = 0;
    for (const WindowTap& t : f.window.taps) {
      ccWeigh(&moments, tapOf(t), 255 * f.density[tissue]);
      volume += static_cast<CcSum>(255 * t.weight);
    }
    block.moments.fill(moments);
    block.volume.fill(volume);
    block.coverage.fill(255);
    block.tissue.fill(static_cast<std::uint8_t>(tissue));
  }
}

void fillBlock(const Bricks& f, const Cloud& cloud, const Eigen::Vector3i& brick,
               FieldBlock& block) {
  for (int k = 0; k < kBrickVoxels; ++k) {
    const VoxelIndex v = kBrickEdge * brick + VoxelIndex(k & 7, k >> 3 & 7, k >> 6);
    const auto at = static_cast<std::size_t>(k);
    block.coverage[at] = cloud.coverage(v.x(), v.y(), v.z());
    block.tissue[at] = f.names.empty() ? std::uint8_t{0} : cloud.material(v.x(), v.y(), v.z());
    if (block.coverage[at] == 0) block.tissue[at] = 0;
    gather(f, cloud, v, block, k);
  }
}

Eigen::Vector3i brickAt(const Bricks& f, std::size_t entry) {
  const auto nx = static_cast<std::size_t>(f.bricks.x()),
             ny = static_cast<std::size_t>(f.bricks.y());
  return {static_cast<int>(entry % nx), static_cast<int>(entry / nx % ny),
          static_cast<int>(entry / (nx * ny))};
}

void sumUp(Bricks& f) {
  const VoxelIndex middle = kBrickEdge / 2 * f.bricks;
  for (std::size_t entry = 0; entry < f.table.size(); ++entry) {
    if (f.table[entry] == kNoBlock) continue;
    const FieldBlock& block = f.blocks[static_cast<std::size_t>(f.table[entry])];
    const VoxelIndex corner = kBrickEdge * brickAt(f, entry) - middle;
    for (int k = 0; k < kBrickVoxels; ++k) {
      const auto at = static_cast<std::size_t>(k);
      f.sums[block.tissue[at]].add(corner + VoxelIndex(k & 7, k >> 3 & 7, k >> 6),
                                   {block.coverage[at], 0, 0});
    }
  }
}

void build(Bricks& f, const Cloud& cloud) {
  const std::vector<int> kinds = kindsOf(cloud);
  f.table.assign(kinds.size(), kNoBlock);
  std::vector<std::size_t> own;  // entries with a block of their own
  for (std::size_t entry = 0; entry < kinds.size(); ++entry) {
    if (kinds[entry] == kVoid) continue;
    const int deep = deepInside(f, kinds, brickAt(f, entry));
    if (deep >= 0)
      f.table[entry] = deep;
    else
      own.push_back(entry);
  }
  f.blocks.resize(f.tissues.size() + own.size());
  fillShared(f);
  parallelFor(own.size(), 0, [&](std::size_t k, int) {
    fillBlock(f, cloud, brickAt(f, own[k]), f.blocks[f.tissues.size() + k]);
  });
  for (std::size_t k = 0; k < own.size(); ++k)
    f.table[own[k]] = static_cast<std::int32_t>(f.tissues.size() + k);
  sumUp(f);
}

}  // namespace

void TissueSums::add(const VoxelIndex& at, const RowSums& row) {
  const std::int64_t x = at.x(), y = at.y(), z = at.z(), all = row.zeroth;
  const std::int64_t alongX = all * x + row.first;
  zeroth += all;
  first[0] += alongX, first[1] += all * y, first[2] += all * z;
  second[0] += all * x * x + 2 * x * row.first + row.second;
  second[1] += all * y * y, second[2] += all * z * z;
  second[3] += alongX * y, second[4] += all * y * z, second[5] += alongX * z;
}

BaseVectorField::BaseVectorField(const Cloud& cloud, const TissueTable& tissues,
                                 const WindowSettings& window)
    : bricks_(std::make_unique<Bricks>()) {
  if (cloud.empty()) throw std::invalid_argument("BaseVectorField: the cloud is empty");
  Bricks& f = *bricks_;
  f.voxelSize = cloud.voxelSize();
  f.origin = cloud.origin();
  f.bricks = cloud.bricks();
  fillTissues(f, cloud, tissues);
  f.window = makeWindow(window, cloud.voxelSize());
  f.windowCenter = f.window.center();
  f.perFull = 1 / (255.0 * static_cast<double>(f.window.weights));
  f.depths = DepthTable(f.window);
  makeRows(f);
  build(f, cloud);
}

BaseVectorField::~BaseVectorField() = default;
BaseVectorField::BaseVectorField(BaseVectorField&&) noexcept = default;
BaseVectorField& BaseVectorField::operator=(BaseVectorField&&) noexcept = default;

double BaseVectorField::voxelSize() const {
  return bricks_->voxelSize;
}
const Vec3& BaseVectorField::origin() const {
  return bricks_->origin;
}
Eigen::Vector3i BaseVectorField::size() const {
  return kBrickEdge * bricks_->bricks;
}
const TissueTable& BaseVectorField::tissues() const {
  return bricks_->tissues;
}
const Window& BaseVectorField::window() const {
  return bricks_->window;
}

std::uint8_t BaseVectorField::coverage(const VoxelIndex& v) const {
  const FieldBlock* const block = bricks_->blockOf(v);
  return block ? block->coverage[static_cast<std::size_t>(Bricks::cell(v.x(), v.y(), v.z()))] : 0;
}

int BaseVectorField::tissue(const VoxelIndex& v) const {
  const FieldBlock* const block = bricks_->blockOf(v);
  return block ? block->tissue[static_cast<std::size_t>(Bricks::cell(v.x(), v.y(), v.z()))] : 0;
}

BaseVector BaseVectorField::at(const VoxelIndex& v) const {
  const FieldBlock* const block = bricks_->blockOf(v);
  if (!block) return {};
  const Bricks::Weighed w = bricks_->weigh(*block, Bricks::cell(v.x(), v.y(), v.z()));
  return {bricks_->voxelSize * w.toRepresentative, w.fraction};
}

std::optional<double> BaseVectorField::depth(const VoxelIndex& v) const {
  const FieldBlock* const block = bricks_->blockOf(v);
  if (!block) return std::nullopt;
  const Bricks::Weighed w = bricks_->weigh(*block, Bricks::cell(v.x(), v.y(), v.z()));
  if (w.fraction <= 0) return std::nullopt;
  const Vec3 outward = w.outward.isZero() ? Vec3::UnitZ() : w.outward;
  return bricks_->voxelSize * bricks_->depths.at(outward, w.fraction);
}

BaseVectorField::Mass BaseVectorField::mass() const {
  const Bricks& f = *bricks_;
  const double h = f.voxelSize, voxel = h * h * h;
  Mass result;
  Vec3 first = Vec3::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < f.sums.size(); ++k) {
    const TissueSums& s = f.sums[k];
    const auto d = [&](std::int64_t sum) { return static_cast<double>(sum) / 255; };
    Eigen::Matrix3d m;
    m << d(s.second[0]), d(s.second[3]), d(s.second[5]), d(s.second[3]), d(s.second[1]),
        d(s.second[4]), d(s.second[5]), d(s.second[4]), d(s.second[2]);
    // A voxel's own spread about its centre.
    m += Eigen::Matrix3d::Identity() * (d(s.zeroth) / 12);
    const double density = f.tissues[k].density;
    result.volume += voxel * d(s.zeroth);
    result.mass += density * voxel * d(s.zeroth);
    first += density * voxel * h * Vec3(d(s.first[0]), d(s.first[1]), d(s.first[2]));
    second += density * voxel * h * h * m;
  }
  if (!(result.mass > 0)) return result;
  const Vec3 center = first / result.mass;
  second -= result.mass * center * center.transpose();
  result.inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
  result.centerOfMass =
      f.origin + h * ((kBrickEdge / 2 * f.bricks).cast<double>() + Vec3::Constant(0.5)) + center;
  return result;
}

Cloud BaseVectorField::cloud() const {
  const Bricks& f = *bricks_;
  auto voxels = std::make_shared<Cloud::Voxels>();
  voxels->bricks = f.bricks;
  voxels->materials = f.names;
  voxels->table.assign(f.table.size(), kEmptyBrick);
  if (!f.names.empty()) voxels->materialTable.assign(f.table.size(), -1);
  for (std::size_t k = 0; k < f.table.size(); ++k) {
    if (f.table[k] == kNoBlock) continue;
    const FieldBlock& block = f.blocks[static_cast<std::size_t>(f.table[k])];
    const auto all = [&](const auto& values, int value) {
      return std::all_of(values.begin(), values.end(), [&](int v) { return v == value; });
    };
    if (all(block.coverage, 255)) {
      voxels->table[k] = kSolidBrick;
    } else if (!all(block.coverage, 0)) {
      voxels->table[k] = static_cast<std::int32_t>(voxels->coverage.size());
      voxels->coverage.push_back(block.coverage);
    }
    if (f.names.empty()) continue;
    if (all(block.tissue, block.tissue[0])) {
      voxels->materialTable[k] = -1 - block.tissue[0];
    } else {
      voxels->materialTable[k] = static_cast<std::int32_t>(voxels->material.size());
      voxels->material.push_back(block.tissue);
    }
  }
  return Cloud(f.voxelSize, f.origin, std::move(voxels));
}

std::uint64_t BaseVectorField::hash() const {
  const Bricks& f = *bricks_;
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a over whole numbers
  const auto mix = [&](std::uint64_t value) { hash = (hash ^ value) * 1099511628211u; };
  for (std::size_t entry = 0; entry < f.table.size(); ++entry) {
    if (f.table[entry] == kNoBlock) continue;
    const FieldBlock& block = f.blocks[static_cast<std::size_t>(f.table[entry])];
    for (std::size_t k = 0; k < kBrickVoxels; ++k) {
      if (block.coverage[k] == 0) continue;
      const CcMoments& m = block.moments[k];
      mix(entry * kBrickVoxels + k);
      mix(static_cast<std::uint64_t>(block.coverage[k]) << 8 | block.tissue[k]);
      for (const CcSum s : {m.mass, m.x, m.y, m.z, block.volume[k]})
        mix(static_cast<std::uint64_t>(static_cast<std::int64_t>(s)));
    }
  }
  for (const TissueSums& s : f.sums) {
    mix(static_cast<std::uint64_t>(s.zeroth));
    for (const std::int64_t v : s.first) mix(static_cast<std::uint64_t>(v));
    for (const std::int64_t v : s.second) mix(static_cast<std::uint64_t>(v));
  }
  return hash;
}

std::size_t BaseVectorField::bytes() const {
  return bricks_->blocks.capacity() * sizeof(FieldBlock) +
         bricks_->table.size() * sizeof(std::int32_t);
}

}  // namespace cloudcontact
