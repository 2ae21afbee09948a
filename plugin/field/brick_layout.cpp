// Lays out a field of base vectors and sums its windows.
#include "field/brick_layout.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>

#include "base/parallel.h"

namespace cloudcontact {

namespace {

using Bricks = BaseVectorBricks;

CcTap tapOf(const WindowTap& t) {
  return {t.weight, t.moment[0], t.moment[1], t.moment[2]};
}

// The mirrored window, as rows.
void makeRows(Bricks& f) {
  for (auto t = f.window.taps.rbegin(); t != f.window.taps.rend(); ++t) {
    const bool continues = !f.rows.empty() && f.rows.back().y == -t->y &&
                           f.rows.back().z == -t->z &&
                           f.rows.back().x + static_cast<int>(f.rows.back().count) == -t->x;
    if (!continues)
      f.rows.push_back({-t->x, -t->y, -t->z, static_cast<std::uint32_t>(f.taps.size()), 0});
    ++f.rows.back().count;
    f.taps.push_back({static_cast<CcSum>(t->weight), static_cast<CcSum>(t->moment[0]),
                      static_cast<CcSum>(t->moment[1]), static_cast<CcSum>(t->moment[2])});
  }
}

void fillTissues(Bricks& f, const std::vector<std::string>& names, const TissueTable& tissues) {
  const std::size_t kinds = std::max<std::size_t>(names.size(), 1);
  validate(tissues);
  if (tissues.size() != kinds)
    throw std::invalid_argument("BaseVectorField: the cloud has " + std::to_string(kinds) +
                                " materials, " + std::to_string(tissues.size()) +
                                " tissues were given (tissuesOf() finds them by name)");
  f.tissues = tissues;
  f.names = names;
  double densest = 0;
  for (const Tissue& t : tissues) densest = std::max(densest, t.density);
  for (const Tissue& t : tissues)
    f.density.push_back(
        std::max(1, static_cast<int>(std::lround(CC_DENSEST * t.density / densest))));
  f.sums.resize(kinds);
}

// The kind of each brick of the cloud: a tissue if it is full of that alone, kMixed or kVoid.
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

// The tissue of a brick whose windows are all full of it, or kMixed.
int deepInside(const Bricks& f, const std::vector<int>& kinds, const Eigen::Vector3i& brick) {
  const auto brickOf = [](const Eigen::Vector3i& v) {
    return Eigen::Vector3i(v.unaryExpr([](int x) { return x >> 3; }));
  };
  const Eigen::Vector3i corner = kBrickEdge * brick;
  const Eigen::Vector3i low = brickOf(corner + f.window.low.cwiseMin(0));
  const Eigen::Vector3i high =
      brickOf(corner + Eigen::Vector3i::Constant(kBrickEdge - 1) + f.window.high.cwiseMax(0));
  if ((low.array() < 0).any() || (high.array() >= f.bricks.array()).any()) return kMixed;
  const auto kind = [&](int x, int y, int z) { return kinds[gridIndex(x, y, z, f.bricks)]; };
  const int own = kind(brick.x(), brick.y(), brick.z());
  if (own < 0) return kMixed;
  for (int z = low.z(); z <= high.z(); ++z)
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x)
        if (kind(x, y, z) != own) return kMixed;
  return own;
}

void fillShared(Bricks& f) {
  f.blocks.resize(f.tissues.size());
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
    const VoxelIndex v = kBrickEdge * brick + cellOffset(k);
    const auto at = static_cast<std::size_t>(k);
    block.coverage[at] = cloud.coverage(v.x(), v.y(), v.z());
    const bool hasMaterial = !f.names.empty() && block.coverage[at] > 0;
    block.tissue[at] = hasMaterial ? cloud.material(v.x(), v.y(), v.z()) : std::uint8_t{0};
  }
}

// Fills the table and the blocks' voxels.
void fillTable(Bricks& f, const Cloud& cloud) {
  const std::vector<int> kinds = kindsOf(cloud);
  f.table.assign(kinds.size(), kNoBlock);
  std::size_t blocks = f.tissues.size();
  for (std::size_t entry = 0; entry < kinds.size(); ++entry) {
    if (kinds[entry] == kVoid) continue;
    const int deep = deepInside(f, kinds, gridCell(entry, f.bricks));
    f.table[entry] = deep >= 0 ? deep : static_cast<std::int32_t>(blocks++);
  }
  f.blocks.resize(blocks);
  const std::vector<std::int32_t> own = ownBricks(f);
  parallelFor(own.size(), 0, [&](std::size_t k, int) {
    fillBlock(f, cloud, gridCell(static_cast<std::size_t>(own[k]), f.bricks),
              f.blocks[f.tissues.size() + k]);
  });
}

}  // namespace

std::unique_ptr<Bricks> startBricks(const FieldGrid& grid, const TissueTable& tissues,
                                    const WindowSettings& window) {
  auto field = std::make_unique<Bricks>();
  Bricks& f = *field;
  f.voxelSize = grid.voxelSize;
  f.origin = grid.origin;
  f.bricks = grid.bricks;
  fillTissues(f, grid.materials, tissues);
  f.window = makeWindow(window, grid.voxelSize);
  f.windowCenter = f.window.center();
  f.perFull = 1 / (255.0 * static_cast<double>(f.window.weights));
  makeRows(f);
  fillShared(f);
  return field;
}

void sumTissues(Bricks& f) {
  for (MatterSums& sums : f.sums) sums = {};
  const VoxelIndex middle = kBrickEdge / 2 * f.bricks;
  for (std::size_t entry = 0; entry < f.table.size(); ++entry) {
    if (f.table[entry] == kNoBlock) continue;
    const FieldBlock& block = f.blocks[static_cast<std::size_t>(f.table[entry])];
    const VoxelIndex corner = kBrickEdge * gridCell(entry, f.bricks) - middle;
    for (int k = 0; k < kBrickVoxels; ++k) {
      const auto at = static_cast<std::size_t>(k);
      f.sums[block.tissue[at]].add(corner + cellOffset(k), block.coverage[at]);
    }
  }
}

void finishBricks(Bricks& f) {
  f.depths = DepthTable(f.window);
  sumTissues(f);
}

std::unique_ptr<Bricks> layOutBricks(const Cloud& cloud, const TissueTable& tissues,
                                     const WindowSettings& window) {
  if (cloud.empty()) throw std::invalid_argument("BaseVectorField: the cloud is empty");
  auto field = startBricks({cloud.voxelSize(), cloud.origin(), cloud.bricks(), cloud.materials()},
                           tissues, window);
  fillTable(*field, cloud);
  finishBricks(*field);
  return field;
}

std::vector<std::int32_t> ownBricks(const Bricks& f) {
  std::vector<std::int32_t> own(f.blocks.size() - f.tissues.size());
  for (std::size_t entry = 0; entry < f.table.size(); ++entry)
    if (f.table[entry] >= static_cast<std::int32_t>(f.tissues.size()))
      own[static_cast<std::size_t>(f.table[entry]) - f.tissues.size()] =
          static_cast<std::int32_t>(entry);
  return own;
}

std::vector<CcWindowTap> windowTaps(const Window& window) {
  std::vector<CcWindowTap> taps;
  for (const WindowTap& t : window.taps) taps.push_back({t.x, t.y, t.z, tapOf(t)});
  return taps;
}

void sumWindows(Bricks& f) {
  const std::vector<CcWindowTap> taps = windowTaps(f.window);
  const CcWorkpiece workpiece = f.workpiece();
  const std::vector<std::int32_t> own = ownBricks(f);
  parallelFor(own.size(), 0, [&](std::size_t n, int) {
    const VoxelIndex low = kBrickEdge * gridCell(static_cast<std::size_t>(own[n]), f.bricks);
    FieldBlock& block = f.blocks[f.tissues.size() + n];
    for (int k = 0; k < kBrickVoxels; ++k)
      ccWindowSum(&workpiece, taps.data(), static_cast<int>(taps.size()), low.x() + (k & 7),
                  low.y() + (k >> 3 & 7), low.z() + (k >> 6),
                  &block.moments[static_cast<std::size_t>(k)],
                  &block.volume[static_cast<std::size_t>(k)]);
  });
}

MassProperties massOf(const Bricks& f, const std::vector<MatterSums>& sums) {
  const double h = f.voxelSize, voxel = h * h * h;
  MassProperties result;
  Vec3 first = Vec3::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const MatterSums& s = sums[k];
    const auto d = [&](std::int64_t sum) { return static_cast<double>(sum) / 255; };
    Eigen::Matrix3d m;
    m << d(s.second[0]), d(s.second[3]), d(s.second[5]), d(s.second[3]), d(s.second[1]),
        d(s.second[4]), d(s.second[5]), d(s.second[4]), d(s.second[2]);
    // Second moment of a voxel about its own center.
    m += Eigen::Matrix3d::Identity() * (d(s.mass) / 12);
    const double density = f.tissues[k].density;
    result.volume += voxel * d(s.mass);
    result.mass += density * voxel * d(s.mass);
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

}  // namespace cloudcontact
