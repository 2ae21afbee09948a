// A cloud in the making, from pieces that each fill a share of some voxels: what every digital kind
// (points, spheres, columns) becomes a cloud by.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <optional>

namespace cloudcontact {

// Where a cloud's voxels will lie.
struct CloudGrid {
  double voxelSize = 0;  // [m]
  Vec3 origin = Vec3::Zero();
  Eigen::Vector3i bricks = Eigen::Vector3i::Zero();
};

// Voxels around a box [m] with two empty ones on every side. Where `lattice` is given, it is a
// corner of voxels, so that what lies on that lattice keeps its voxels; otherwise the box is in the
// grid's middle. `what` begins the message of std::invalid_argument (a bad voxel size or an endless
// box) and std::length_error (more bricks than 4 GB of table hold; says what would fit).
CloudGrid cloudGrid(const char* what, const Eigen::AlignedBox3d& box, double voxelSize,
                    const std::optional<Vec3>& lattice = {});

// Shares add up in each voxel, up to 1; a voxel is of the material that gave it most in one piece.
class CloudBuilder {
 public:
  CloudBuilder(const CloudGrid& grid, std::vector<std::string> materials);

  const CloudGrid& grid() const { return grid_; }
  // Voxels outside the grid are passed over.
  void add(const Eigen::Vector3i& voxel, double share, std::uint8_t material = 0);
  // A box [m] of which `share` is material, evenly.
  void addBox(const Vec3& low, const Vec3& high, double share, std::uint8_t material = 0);
  // Bricks that turned out alike all over store no numbers.
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

// Puts one brick behind the others in `voxels`, whose table has an entry for it: a number where all
// of it is alike. `material` may be null.
void storeBrick(Cloud::Voxels& voxels, std::size_t entry, const BrickCoverage& coverage,
                const BrickMaterial* material);

}  // namespace cloudcontact
