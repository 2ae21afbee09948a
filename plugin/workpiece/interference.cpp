// Bricks of either cloud that hold material near material of the other are listed. Then the side
// with fewer voxels in them is walked: each voxel of the workpiece is looked up in the tool, or
// each of the tool finds the centers inside it. Both give the same voxels to the bit, as both ask
// the same point in the same arithmetic.
#include <cloudcontact/workpiece/interference.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/grid_index.h"
#include "base/parallel.h"
#include "voxels/cut_between.h"

namespace cloudcontact {

namespace {

using Eigen::Vector3i;
using Voxels = std::vector<VoxelIndex>;

constexpr int kHalfCovered = 128;  // of 255
constexpr double kHair = 1e-9;     // rounding error of a place [voxels]
// Walking the tool, about eight centers are tested for each of its voxels.
constexpr std::size_t kTestsPerToolVoxel = 6;

bool before(const VoxelIndex& a, const VoxelIndex& b) {
  if (a.z() != b.z()) return a.z() < b.z();
  return a.y() != b.y() ? a.y() < b.y() : a.x() < b.x();
}

// A point in voxels of one cloud as a point in voxels of another.
struct Map {
  Eigen::Matrix3d turn;
  Vec3 shift;
  double scale;  // length of a voxel in the other's
  Vec3 operator()(const Vec3& point) const { return turn * point + shift; }
};

Map mapOf(const Cloud& from, const Cloud& to, const Pose& fromInTo) {
  const double scale = from.voxelSize() / to.voxelSize();
  return {scale * fromInTo.orientation.toRotationMatrix(),
          (fromInTo.toWorld(from.origin()) - to.origin()) / to.voxelSize(), scale};
}

Vec3 middleOf(const Vector3i& voxel) {
  return voxel.cast<double>() + Vec3::Constant(0.5);
}

// Calls visit(brick) for all bricks of a grid that a box touches [voxels], until it returns true.
template <typename Visit>
bool anyBrick(const Vector3i& bricks, const Vec3& low, const Vec3& high, Visit&& visit) {
  const Vec3 last = (bricks - Vector3i::Ones()).cast<double>();
  const Vec3 a = (low / kBrickEdge).array().floor().max(0).matrix();
  const Vec3 b = (high / kBrickEdge).array().floor().matrix().cwiseMin(last);
  for (int z = static_cast<int>(std::min(a.z(), 1e9)); z <= b.z(); ++z)
    for (int y = static_cast<int>(std::min(a.y(), 1e9)); y <= b.y(); ++y)
      for (int x = static_cast<int>(std::min(a.x(), 1e9)); x <= b.x(); ++x)
        if (visit(Vector3i(x, y, z))) return true;
  return false;
}

// The voxels of a brick with a coverage of `least`.
std::size_t voxelsIn(const Cloud& cloud, std::int32_t stored, int least) {
  if (stored < 0) return stored == kSolidBrick ? kBrickVoxels : 0;
  int count = 0;
  for (const std::uint8_t c : cloud.voxels().coverage[static_cast<std::size_t>(stored)])
    count += c >= least;
  return static_cast<std::size_t>(count);
}

// The bricks of a cloud that may meet another, and their voxels with a coverage of `least`.
struct Near {
  std::vector<Vector3i> bricks;
  std::size_t voxels = 0;
};

Near nearOf(const Cloud& cloud, const Map& toOther, const Cloud& other, const Map& fromOther,
            int least) {
  Near near;
  // The other's grid as a box in this one.
  const Vec3 half = 0.5 * other.size().cast<double>();
  const Vec3 middle = fromOther(half), reach = fromOther.turn.cwiseAbs() * half;
  const double brickReach = kHalfDiagonal * kBrickEdge * toOther.scale + kHair;
  anyBrick(cloud.bricks(), middle - reach, middle + reach, [&](const Vector3i& brick) {
    const std::int32_t stored = cloud.voxels().table[gridIndex(brick, cloud.bricks())];
    if (stored == kEmptyBrick) return false;
    const Vec3 center = toOther(kBrickEdge * (brick.cast<double>() + Vec3::Constant(0.5)));
    const Vec3 around = Vec3::Constant(brickReach);
    if (!anyBrick(other.bricks(), center - around, center + around, [&](const Vector3i& b) {
          return other.voxels().table[gridIndex(b, other.bricks())] != kEmptyBrick;
        }))
      return false;
    near.bricks.push_back(brick);
    near.voxels += voxelsIn(cloud, stored, least);
    return false;
  });
  return near;
}

struct Pair {
  const Cloud &tool, &work;
  Map toTool, toWork;

  // The center of the first voxel of a row of a brick, in the tool. The others of the row follow in
  // equal steps.
  Vec3 rowStart(const Vector3i& voxel) const {
    return toTool(middleOf({voxel.x() - voxel.x() % kBrickEdge, voxel.y(), voxel.z()}));
  }
  // The tool's voxel around the center of a voxel of the workpiece.
  Vector3i toolVoxelAt(const Vec3& start, int x) const {
    return (start + x % kBrickEdge * toTool.turn.col(0)).array().floor().cast<int>();
  }
  bool isTool(const Vector3i& voxel) const {
    if (!insideGrid(voxel, tool.size())) return false;
    const std::int32_t stored = tool.voxels().table[brickIndex(voxel, tool.bricks())];
    return coverageIn(tool.voxels(), stored, cellIndex(voxel)) >= kHalfCovered;
  }

  void walkWork(const Vector3i& brick, Voxels& found) const {
    const std::int32_t stored = work.voxels().table[gridIndex(brick, work.bricks())];
    for (int row = 0; row < kBrickVoxels; row += kBrickEdge) {
      const Vector3i first = kBrickEdge * brick + cellOffset(row);
      const Vec3 start = rowStart(first);
      for (int x = 0; x < kBrickEdge; ++x)
        if (coverageIn(work.voxels(), stored, row + x) > 0 && isTool(toolVoxelAt(start, x)))
          found.emplace_back(first.x() + x, first.y(), first.z());
    }
  }

  void walkTool(const Vector3i& brick, Voxels& found) const {
    const std::int32_t stored = tool.voxels().table[gridIndex(brick, tool.bricks())];
    // Half the box around a voxel of the tool; the centers in it are candidates.
    const Vec3 half = (0.5 + kHair) * toWork.turn.cwiseAbs().rowwise().sum();
    for (int cell = 0; cell < kBrickVoxels; ++cell)
      if (coverageIn(tool.voxels(), stored, cell) >= kHalfCovered)
        addCentersIn(kBrickEdge * brick + cellOffset(cell), half, found);
  }

 private:
  void addCentersIn(const Vector3i& toolVoxel, const Vec3& half, Voxels& found) const {
    const Vec3 middle = toWork(middleOf(toolVoxel)) - Vec3::Constant(0.5);
    const Vector3i low = (middle - half).array().ceil().cast<int>().max(0);
    const Vector3i high = Vector3i((middle + half).array().floor().cast<int>())
                              .cwiseMin(work.size() - Vector3i::Ones());
    for (int z = low.z(); z <= high.z(); ++z)
      for (int y = low.y(); y <= high.y(); ++y)
        for (int x = low.x(); x <= high.x(); ++x)
          if (work.coverage(x, y, z) > 0 && toolVoxelAt(rowStart({x, y, z}), x) == toolVoxel)
            found.emplace_back(x, y, z);
  }
};

}  // namespace

Voxels interference(const Cloud& tool, const Pose& toolPlace, const Cloud& workpiece, int threads) {
  if (!toolPlace.position.allFinite() || !toolPlace.orientation.coeffs().allFinite())
    throw std::invalid_argument("interference: the tool's place must be finite");
  if (tool.empty() || workpiece.empty()) return {};
  const Pair pair{tool, workpiece, mapOf(workpiece, tool, toolPlace.inverse()),
                  mapOf(tool, workpiece, toolPlace)};
  const Near work = nearOf(workpiece, pair.toTool, tool, pair.toWork, 1);
  if (work.bricks.empty()) return {};
  const Near ofTool = nearOf(tool, pair.toWork, workpiece, pair.toTool, kHalfCovered);
  const bool walksTool = kTestsPerToolVoxel * ofTool.voxels < work.voxels;
  const std::vector<Vector3i>& bricks = walksTool ? ofTool.bricks : work.bricks;
  std::vector<Voxels> found(bricks.size());
  parallelFor(bricks.size(), threads, [&](std::size_t k, int) {
    if (walksTool)
      pair.walkTool(bricks[k], found[k]);
    else
      pair.walkWork(bricks[k], found[k]);
  });
  Voxels all;
  for (const Voxels& part : found) all.insert(all.end(), part.begin(), part.end());
  std::sort(all.begin(), all.end(), before);
  return all;
}

}  // namespace cloudcontact
