// Clouds made by formula and cuts into them, for tests of bodies that are cut. Lengths in voxels,
// in the cloud's grid.
#pragma once

#include <cloudcontact/voxels/pieces.h>

#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "contact/contact_cases.h"

namespace cloudcontact::testing {

using Inside = std::function<bool(const Vec3&)>;

// The fraction of a voxel inside the body, by n x n x n points [1/255].
inline int coverageOf(const Inside& solid, int x, int y, int z, int n = 4) {
  int inside = 0;
  const int all = n * n * n;
  for (int k = 0; k < all; ++k)
    inside += solid(Vec3(x, y, z) + (Vec3(k % n, k / n % n, k / n / n) + Vec3::Constant(0.5)) / n);
  return (inside * 255 + all / 2) / all;
}

inline Cloud cloudOf(const Inside& solid, const Eigen::Vector3i& bricks, double voxel = 1e-3) {
  auto voxels = std::make_shared<Cloud::Voxels>();
  voxels->bricks = bricks;
  for (int t = 0; t < bricks.prod(); ++t) {
    const Eigen::Vector3i low = 8 * Eigen::Vector3i(t % bricks.x(), t / bricks.x() % bricks.y(),
                                                    t / bricks.x() / bricks.y());
    BrickCoverage brick;
    int full = 0, empty = 0;
    for (int k = 0; k < kBrickVoxels; ++k) {
      const int c =
          coverageOf(solid, low.x() + (k & 7), low.y() + (k >> 3 & 7), low.z() + (k >> 6));
      brick[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(c);
      full += c == 255;
      empty += c == 0;
    }
    const bool even = full == kBrickVoxels || empty == kBrickVoxels;
    voxels->table.push_back(!even      ? static_cast<std::int32_t>(voxels->coverage.size())
                            : full > 0 ? kSolidBrick
                                       : kEmptyBrick);
    if (!even) voxels->coverage.push_back(brick);
  }
  return Cloud(voxel, Vec3(0.1, -0.2, 0.05), voxels);
}

inline Inside ball(const Vec3& center, double radius) {
  return [=](const Vec3& p) { return (p - center).squaredNorm() < radius * radius; };
}

inline Inside tiltedBox(const Vec3& center, const Vec3& half) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5, Vec3(1, 2, -1).normalized()));
  return [=](const Vec3& p) {
    return ((turn.conjugate() * (p - center)).cwiseAbs().array() < half.array()).all();
  };
}

// A crown with four cusps and a fissure, on two roots that end in tips; 30 x 30 x 44 voxels.
inline Inside tooth(const Vec3& center) {
  return [=](const Vec3& at) {
    const Vec3 p = at - center;
    const double cusps = 2.5 * std::cos(p.x() / 3) * std::cos(p.y() / 3);
    const bool crown = std::pow(p.x() / 13, 4) + std::pow(p.y() / 11, 4) < 1 && p.z() > 0 &&
                       p.z() < 12 + cusps && !(std::abs(p.y()) < 0.8 && p.z() > 9);
    const double left = -p.z() / 18;
    const bool root = left >= 0 && left < 1 &&
                      std::hypot((std::abs(p.x()) - 7 - 2 * left) / 5, p.y() / 9) < 1 - left;
    return crown || root;
  };
}

// The cuts of all voxels that a tool meets.
inline std::vector<VoxelCut> cutsOf(const Cloud& cloud, const Inside& tool, const Vec3& low,
                                    const Vec3& high, int points = 4) {
  std::vector<VoxelCut> cuts;
  const Eigen::Vector3i first = low.array().floor().cast<int>().max(0);
  const Eigen::Vector3i last = high.array().ceil().cast<int>().min(cloud.size().array() - 1);
  for (int z = first.z(); z <= last.z(); ++z)
    for (int y = first.y(); y <= last.y(); ++y)
      for (int x = first.x(); x <= last.x(); ++x)
        if (const int taken = coverageOf(tool, x, y, z, points))
          cuts.push_back({{x, y, z}, static_cast<std::uint8_t>(255 - taken)});
  return cuts;
}

inline std::vector<VoxelCut> bite(const Cloud& cloud, const Vec3& center, double radius,
                                  int points = 4) {
  return cutsOf(cloud, ball(center, radius), center - Vec3::Constant(radius),
                center + Vec3::Constant(radius), points);
}

// A saw's cut: all material between two planes across x.
inline std::vector<VoxelCut> sawn(const Cloud& cloud, double from, double to) {
  return cutsOf(
      cloud, [=](const Vec3& p) { return p.x() >= from && p.x() < to; }, Vec3(from, 0, 0),
      Vec3(to, cloud.size().y(), cloud.size().z()));
}

// Random voxels, each cut to a random value.
inline std::vector<VoxelCut> specks(const Cloud& cloud, Random& random, int count) {
  std::vector<VoxelCut> cuts;
  for (int k = 0; k < count; ++k) {
    const Vec3 at = random.inCube().cwiseProduct(cloud.size().cast<double>());
    cuts.push_back(
        {at.array().floor().cast<int>(), static_cast<std::uint8_t>(255 * random.uniform())});
  }
  return cuts;
}

}  // namespace cloudcontact::testing
