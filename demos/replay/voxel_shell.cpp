// Goes brick by brick and skips bricks that are empty or solid with solid neighbors.
#include "replay/voxel_shell.h"

namespace cloudcontact::program {
namespace {

constexpr int kHalf = 128;

// The cloud in cubes of block^3 voxels; block is a power of two.
class Cubes {
 public:
  Cubes(const Cloud& cloud, int block) : cloud_(cloud), block_(block) {}

  Eigen::Vector3i size() const {
    return (cloud_.size() + Eigen::Vector3i::Constant(block_ - 1)) / block_;
  }
  int coverage(int x, int y, int z) const {
    if (block_ == 1) return cloud_.coverage(x, y, z);
    int sum = 0;
    for (int k = 0; k < block_; ++k)
      for (int j = 0; j < block_; ++j)
        for (int i = 0; i < block_; ++i)
          sum += cloud_.coverage(x * block_ + i, y * block_ + j, z * block_ + k);
    return sum / (block_ * block_ * block_);
  }
  int openFaces(int x, int y, int z) const {
    static constexpr int kSteps[6][3] = {{-1, 0, 0}, {1, 0, 0},  {0, -1, 0},
                                         {0, 1, 0},  {0, 0, -1}, {0, 0, 1}};
    int open = 0;
    for (int face = 0; face < 6; ++face) {
      const int* s = kSteps[face];
      if (coverage(x + s[0], y + s[1], z + s[2]) < kHalf) open |= 1 << face;
    }
    return open;
  }
  // No surface in this brick nor at its faces.
  bool dull(const Eigen::Vector3i& brick) const {
    const int own = table(brick);
    if (own == kEmptyBrick) return true;
    if (own != kSolidBrick) return false;
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1})
        if (table(brick + side * Eigen::Vector3i::Unit(axis)) != kSolidBrick) return false;
    return true;
  }

 private:
  int table(const Eigen::Vector3i& brick) const {
    const Eigen::Vector3i n = cloud_.bricks();
    if ((brick.array() < 0).any() || (brick.array() >= n.array()).any()) return kEmptyBrick;
    return cloud_.voxels()
        .table[static_cast<std::size_t>(brick.x()) +
               static_cast<std::size_t>(n.x()) *
                   (static_cast<std::size_t>(brick.y()) +
                    static_cast<std::size_t>(n.y()) * static_cast<std::size_t>(brick.z()))];
  }

  const Cloud& cloud_;
  int block_;
};

void addBrick(VoxelShell& shell, const Cubes& cubes, const Eigen::Vector3i& brick, int edge) {
  const Eigen::Vector3i low = brick * edge;
  for (int z = low.z(); z < low.z() + edge; ++z)
    for (int y = low.y(); y < low.y() + edge; ++y)
      for (int x = low.x(); x < low.x() + edge; ++x) {
        const int coverage = cubes.coverage(x, y, z);
        if (coverage < kHalf) continue;
        const int open = cubes.openFaces(x, y, z);
        if (open == 0) continue;
        shell.x.push_back(static_cast<std::uint16_t>(x));
        shell.y.push_back(static_cast<std::uint16_t>(y));
        shell.z.push_back(static_cast<std::uint16_t>(z));
        shell.coverage.push_back(static_cast<std::uint8_t>(coverage));
        shell.open.push_back(static_cast<std::uint8_t>(open));
      }
}

VoxelShell shellOf(const Cloud& cloud, int block) {
  VoxelShell shell;
  shell.block = block;
  shell.edge = block * cloud.voxelSize();
  shell.origin = cloud.origin();
  const Cubes cubes(cloud, block);
  const Eigen::Vector3i n = cloud.bricks();
  for (int z = 0; z < n.z(); ++z)
    for (int y = 0; y < n.y(); ++y)
      for (int x = 0; x < n.x(); ++x)
        if (!cubes.dull({x, y, z})) addBrick(shell, cubes, {x, y, z}, kBrickEdge / block);
  return shell;
}

}  // namespace

VoxelShell voxelShell(const Cloud& cloud, std::size_t mostCubes) {
  constexpr int kMostAlong = 65536;  // limit of the coordinates
  for (int block = 1;; block *= 2) {
    if (cloud.size().maxCoeff() / block > kMostAlong && block < kBrickEdge) continue;
    VoxelShell shell = shellOf(cloud, block);
    if (shell.x.size() <= mostCubes || block == kBrickEdge) return shell;
  }
}

}  // namespace cloudcontact::program
