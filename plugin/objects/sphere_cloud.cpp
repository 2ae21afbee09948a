// The union of spheres as voxels: see sphere_cloud.h.
//
// Spheres are listed by the bricks that they reach. A voxel inside one sphere is full, one that no
// sphere reaches is empty. Other voxels are divided: each small cube is cut by the sphere that it
// lies deepest in, as by a plane shifted for the sphere's curvature.
#include <cloudcontact/objects/sphere_cloud.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/grid_index.h"
#include "base/parallel.h"
#include "kernels/base/plane_cell.h"
#include "voxels/cloud_builder.h"

namespace cloudcontact {

namespace {

using Eigen::Vector3i;

constexpr int kParts = 4;  // along a voxel's edge

// Spheres in voxels, in the grid's frame.
struct Ball {
  Vec3 center;
  double radius;
  std::uint8_t material;
  // Positive inside.
  double depthAt(const Vec3& x) const { return radius - (x - center).norm(); }
};

// The share of a small cube that lies in a ball.
double shareOf(const Ball& ball, const Vec3& middle, double edge) {
  const Vec3 out = middle - ball.center;
  const double far = out.norm();
  if (far < 1e-9) return ball.radius > 0.62 * edge ? 1 : 0;
  // The sphere lies below its tangent plane by edge^2 / 12 r, in the mean over the cube.
  const double offset = (ball.radius - far - edge * edge / (12 * ball.radius)) / edge;
  const Vec3 n = out / far;
  return ccCutCube(n[0], n[1], n[2], offset).volume;
}

class BrickFiller {
 public:
  BrickFiller(const std::vector<Ball>& balls, const std::vector<std::uint32_t>& here)
      : balls_(balls), here_(here) {}

  void fill(const Vector3i& corner, BrickCoverage& coverage, BrickMaterial& material) {
    const Vec3 middle = corner.cast<double>() + Vec3::Constant(0.5 * kBrickEdge);
    for (const std::uint32_t i : here_)
      if (balls_[i].depthAt(middle) >= kBrickEdge * kHalfDiagonal) {  // contains the brick
        coverage.fill(255);
        material.fill(balls_[i].material);
        return;
      }
    for (int v = 0; v < kBrickVoxels; ++v) {
      const Vector3i at = corner + cellOffset(v);
      std::uint8_t of = 0;
      const double share = shareAt(at.cast<double>() + Vec3::Constant(0.5), of);
      coverage[v] = static_cast<std::uint8_t>(255 * share + 0.5);
      material[v] = of;
    }
  }

 private:
  double shareAt(const Vec3& middle, std::uint8_t& material) {
    double deepest = -1e300;
    for (const std::uint32_t i : here_)
      if (const double d = balls_[i].depthAt(middle); d > deepest)
        deepest = d, material = balls_[i].material;
    if (deepest <= -kHalfDiagonal) return 0;
    if (deepest >= kHalfDiagonal) return 1;
    // From the center to a corner, the difference of two depths changes by at most a diagonal.
    near_.clear();
    for (const std::uint32_t i : here_)
      if (balls_[i].depthAt(middle) >= deepest - 2 * kHalfDiagonal) near_.push_back(i);
    double sum = 0;
    for (int k = 0; k < kParts * kParts * kParts; ++k) {
      const Vec3 part(k % kParts, k / kParts % kParts, k / (kParts * kParts));
      sum += partAt(middle + (part.array() + 0.5).matrix() / kParts - Vec3::Constant(0.5));
    }
    return std::clamp(sum / (kParts * kParts * kParts), 0.0, 1.0);
  }

  double partAt(const Vec3& middle) const {
    constexpr double kEdge = 1.0 / kParts;
    const Ball* ball = nullptr;
    double deepest = -kHalfDiagonal * kEdge;
    for (const std::uint32_t i : near_)
      if (const double d = balls_[i].depthAt(middle); d > deepest) deepest = d, ball = &balls_[i];
    return ball ? shareOf(*ball, middle, kEdge) : 0;
  }

  const std::vector<Ball>& balls_;
  const std::vector<std::uint32_t>& here_;
  std::vector<std::uint32_t> near_;
};

bool reaches(const Ball& ball, const Vector3i& brick) {
  const Vec3 low = kBrickEdge * brick.cast<double>();
  const Vec3 nearest = ball.center.cwiseMax(low).cwiseMin(low + Vec3::Constant(kBrickEdge));
  return (nearest - ball.center).squaredNorm() <= ball.radius * ball.radius;
}

// The balls that reach each brick.
std::vector<std::vector<std::uint32_t>> listByBrick(const std::vector<Ball>& balls,
                                                    const Vector3i& bricks) {
  std::vector<std::vector<std::uint32_t>> lists(bricks.cast<std::size_t>().prod());
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Ball& b = balls[i];
    const auto brickOf = [&](double sign) {
      const Vec3 x = ((b.center.array() + sign * b.radius) / kBrickEdge).floor();
      return Vector3i(x.cast<int>().cwiseMax(Vector3i::Zero()).cwiseMin(bricks - Vector3i::Ones()));
    };
    const Vector3i low = brickOf(-1), high = brickOf(1);
    for (int z = low[2]; z <= high[2]; ++z)
      for (int y = low[1]; y <= high[1]; ++y)
        for (int x = low[0]; x <= high[0]; ++x)
          if (reaches(b, {x, y, z}))
            lists[gridIndex(x, y, z, bricks)].push_back(static_cast<std::uint32_t>(i));
  }
  return lists;
}

struct Filled {
  BrickCoverage coverage;
  BrickMaterial material;
};

}  // namespace

void validate(const SphereCloud& s) {
  const auto fail = [](const std::string& why) { throw std::invalid_argument("spheres: " + why); };
  if (s.radii.size() != s.centers.size()) fail("radii must be as many as centers");
  if (!s.material.empty() && s.material.size() != s.centers.size())
    fail("material must be as many as centers, or none");
  if (s.materials.size() > 256) fail("more than 256 materials");
  for (const Vec3& c : s.centers)
    if (!c.allFinite()) fail("a center is NaN or infinite");
  for (const double r : s.radii)
    if (!(r > 0) || !std::isfinite(r)) fail("a radius is not positive and finite [m]");
  for (const std::uint8_t m : s.material)
    if (m > 0 && m >= s.materials.size()) fail("a sphere names no material");
}

Cloud toCloud(const SphereCloud& spheres, double voxelSize, int threads) {
  validate(spheres);
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < spheres.centers.size(); ++i) {
    box.extend(Vec3(spheres.centers[i].array() - spheres.radii[i]));
    box.extend(Vec3(spheres.centers[i].array() + spheres.radii[i]));
  }
  const CloudGrid grid = cloudGrid("spheres", box, voxelSize);
  std::vector<Ball> balls;
  for (std::size_t i = 0; i < spheres.centers.size(); ++i)
    balls.push_back({(spheres.centers[i] - grid.origin) / voxelSize, spheres.radii[i] / voxelSize,
                     spheres.material.empty() ? std::uint8_t{0} : spheres.material[i]});
  const auto lists = listByBrick(balls, grid.bricks);
  std::vector<std::unique_ptr<Filled>> filled(lists.size());
  parallelFor(lists.size(), threads, [&](std::size_t entry, int) {
    if (lists[entry].empty()) return;
    const Vector3i brick = gridCell(entry, grid.bricks);
    filled[entry] = std::make_unique<Filled>();
    BrickFiller(balls, lists[entry])
        .fill(kBrickEdge * brick, filled[entry]->coverage, filled[entry]->material);
  });
  auto voxels = emptyVoxels(grid.bricks, spheres.materials);
  for (std::size_t entry = 0; entry < lists.size(); ++entry)
    if (filled[entry])
      storeBrick(*voxels, entry, filled[entry]->coverage,
                 spheres.materials.empty() ? nullptr : &filled[entry]->material);
  return Cloud(voxelSize, grid.origin, std::move(voxels));
}

}  // namespace cloudcontact
