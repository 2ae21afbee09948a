// Looks up the voxels at the surface of the fine cloud in the coarse field.
#include "field/level_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "base/grid_index.h"

namespace cloudcontact {

namespace {

constexpr double kUnseen = std::numeric_limits<double>::infinity();
constexpr double kLeastSlope =
    1e-3;  // a normal's components are at least this: the formula divides
constexpr int kHalvings = 24;

// The share of a unit cube below a plane: that of a box of edges `n` below x + y + z = t.
double shareBelow(const Vec3& n, double t) {
  const auto cube = [](double x) { return x > 0 ? x * x * x : 0.0; };
  const double sum = cube(t) - cube(t - n[0]) - cube(t - n[1]) - cube(t - n[2]) +
                     cube(t - n[0] - n[1]) + cube(t - n[0] - n[2]) + cube(t - n[1] - n[2]) -
                     cube(t - n[0] - n[1] - n[2]);
  return sum / (6 * n[0] * n[1] * n[2]);
}

// Sums of squares over the fine voxels in each coarse one.
class Errors {
 public:
  Errors(const SurfaceField& coarse, const Cloud& fine) : coarse_(coarse), fine_(fine) {}

  // A fine voxel that the surface cuts.
  void addCut(const Eigen::Vector3i& v, int coverage) {
    const Vec3 center = fine_.center(v.x(), v.y(), v.z());
    const auto found = coarse_.at(center);
    if (!found) return add(center, kUnseen);
    const double depth = fine_.voxelSize() * depthByCoverage(found->normal, coverage / 255.0);
    add(center, found->depth - depth);
    // A wall thinner than a coarse voxel may look right on its surface, and wrong beside it.
    const double aside = coarse_.cloud().voxelSize();
    for (const double way : {-aside, aside}) addSide(center, center + way * found->normal);
  }
  // A face between a full fine voxel and an empty one.
  void addFace(const Vec3& place) {
    const auto found = coarse_.at(place);
    add(place, found ? found->depth : kUnseen);
  }

  template <typename Visit>
  void forEach(Visit&& visit) const {
    for (const auto& [voxel, sum] : sums_) visit(voxel, std::sqrt(sum.squares / sum.count));
  }

 private:
  struct Sum {
    double squares = 0;
    double count = 0;
  };

  // On which side `place` is, for the coarse voxel of `home`.
  void addSide(const Vec3& home, const Vec3& place) {
    const Eigen::Vector3i v =
        ((place - fine_.origin()) / fine_.voxelSize()).array().floor().cast<int>();
    const int coverage = fine_.coverage(v.x(), v.y(), v.z());
    if (coverage != 0 && coverage != 255) return;
    const auto found = coarse_.at(place);
    if (!found) return;
    const double wrong = coverage == 0 ? found->depth : -found->depth;
    if (wrong > 0) add(home, wrong);
  }
  void add(const Vec3& place, double error) {
    const Cloud& cloud = coarse_.cloud();
    const Eigen::Vector3i v =
        ((place - cloud.origin()) / cloud.voxelSize()).array().floor().cast<int>();
    Sum& sum = sums_[gridIndex(v, cloud.size())];
    sum.squares += error * error;
    sum.count += 1;
  }

  const SurfaceField& coarse_;
  const Cloud& fine_;
  std::unordered_map<std::size_t, Sum> sums_;
};

const Eigen::Vector3i kAside[6] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                   {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};

bool isBuried(const Cloud::Voxels& voxels, const Eigen::Vector3i& brick) {
  for (const Eigen::Vector3i& way : kAside) {
    const Eigen::Vector3i at = brick + way;
    if (!insideGrid(at, voxels.bricks) || voxels.table[gridIndex(at, voxels.bricks)] != kSolidBrick)
      return false;
  }
  return true;
}

void addBrick(const Cloud& fine, const Eigen::Vector3i& brick, Errors& errors) {
  for (int k = 0; k < kBrickVoxels; ++k) {
    const Eigen::Vector3i v = kBrickEdge * brick + cellOffset(k);
    const int coverage = fine.coverage(v.x(), v.y(), v.z());
    if (coverage == 0) continue;
    if (coverage < 255) {
      errors.addCut(v, coverage);
      continue;
    }
    for (const Eigen::Vector3i& way : kAside) {
      const Eigen::Vector3i at = v + way;
      if (fine.coverage(at.x(), at.y(), at.z()) != 0) continue;
      errors.addFace(fine.center(v.x(), v.y(), v.z()) +
                     0.5 * fine.voxelSize() * way.cast<double>());
    }
  }
}

}  // namespace

double depthByCoverage(const Vec3& normal, double share) {
  const Vec3 n = normal.cwiseAbs().cwiseMax(kLeastSlope);
  double low = 0, high = n.sum();
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (low + high);
    (shareBelow(n, middle) < share ? low : high) = middle;
  }
  return 0.5 * (low + high) - 0.5 * n.sum();
}

LevelError::LevelError(const SurfaceField& coarse, const Cloud& fine)
    : origin_(coarse.cloud().origin()),
      brick_(kBrickEdge * coarse.cloud().voxelSize()),
      size_(coarse.cloud().bricks()),
      bricks_(coarse.cloud().voxels().table.size(), 0.f) {
  Errors errors(coarse, fine);
  const Cloud::Voxels& voxels = fine.voxels();
  for (std::size_t entry = 0; entry < voxels.table.size(); ++entry) {
    if (voxels.table[entry] == kEmptyBrick) continue;
    const Eigen::Vector3i brick = gridCell(entry, voxels.bricks);
    if (voxels.table[entry] == kSolidBrick && isBuried(voxels, brick)) continue;
    addBrick(fine, brick, errors);
  }
  errors.forEach([&](std::size_t voxel, double error) {
    float& most = bricks_[brickIndex(gridCell(voxel, coarse.cloud().size()), size_)];
    most = std::max(most, static_cast<float>(error));
    most_ = std::max(most_, double(static_cast<float>(error)));
  });
}

LevelError LevelError::unseen() {
  LevelError error;
  error.most_ = kUnseen;
  return error;
}

double LevelError::in(const Eigen::AlignedBox3d& region) const {
  if (region.isEmpty()) return 0;
  if (bricks_.empty()) return most_;
  const Vec3 last = (size_ - Eigen::Vector3i::Ones()).cast<double>();
  const auto brickOf = [&](const Vec3& place) -> Vec3 {
    return ((place - origin_) / brick_).array().floor();
  };
  const Vec3 low = brickOf(region.min()).cwiseMax(0), high = brickOf(region.max()).cwiseMin(last);
  if (!(low.array() <= high.array()).all()) return 0;
  const Eigen::Vector3i from = low.cast<int>(), to = high.cast<int>();
  float most = 0;
  for (int z = from.z(); z <= to.z(); ++z)
    for (int y = from.y(); y <= to.y(); ++y)
      for (int x = from.x(); x <= to.x(); ++x)
        most = std::max(most, bricks_[gridIndex(x, y, z, size_)]);
  return most;
}

}  // namespace cloudcontact
