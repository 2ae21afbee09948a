// CloudBuilder: builds a cloud from pieces that each fill a share of some voxels. Points, spheres
// and columns become clouds through it.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <optional>

namespace cloudcontact {

// The grid of a future cloud.
struct CloudGrid {
  double voxelSize = 0;  // [m]
  Vec3 origin = Vec3::Zero();
  Eigen::Vector3i bricks = Eigen::Vector3i::Zero();
};

// The grid around a box [m], with two empty voxels on every side. `lattice`, where given, becomes a
// corner of voxels, so that bodies on that lattice keep their voxels; otherwise the box is centered
// in the grid. Throws std::invalid_argument on a bad voxel size or an infinite box,
// std::length_error where the table of bricks would exceed 4 GB (the message names a size that
// fits). Messages begin with `what`.
CloudGrid cloudGrid(const char* what, const Eigen::AlignedBox3d& box, double voxelSize,
                    const std::optional<Vec3>& lattice = {});

// Adds shares in each voxel, up to 1. A voxel is of the material of its largest single piece.
class CloudBuilder {
 public:
  CloudBuilder(const CloudGrid& grid, std::vector<std::string> materials);

  const CloudGrid& grid() const { return grid_; }
  // Adds `share` of a voxel. Voxels outside the grid are ignored.
  void add(const Eigen::Vector3i& voxel, double share, std::uint8_t material = 0);
  // Adds a box [m] filled evenly by `share`.
  void addBox(const Vec3& low, const Vec3& high, double share, std::uint8_t material = 0);
  // The cloud. Uniform bricks store no numbers.
  Cloud build() const;

 private:
  struct Brick {
    std::array<float, kBrickVoxels> share{};
    std::array<float, kBrickVoxels> most{};  // largest piece so far
    BrickMaterial material{};
  };
  CloudGrid grid_;
  std::vector<std::string> materials_;
  std::vector<std::int32_t> table_;
  std::vector<Brick> bricks_;
};

// Voxels of a grid without any matter yet.
std::shared_ptr<Cloud::Voxels> emptyVoxels(const Eigen::Vector3i& bricks,
                                           const std::vector<std::string>& materials);

// Appends one brick to `voxels` and sets its table entries. A uniform brick is stored as a code
// alone. `material` may be null.
void storeBrick(Cloud::Voxels& voxels, std::size_t entry, const BrickCoverage& coverage,
                const BrickMaterial* material);

}  // namespace cloudcontact
