// Cloud: a body as voxels. Each voxel holds its coverage, the fraction of it that is material, and
// in bodies of several materials which one (docs/method.md, "Coverage"). The grid is sparse: of its
// 8x8x8 bricks only those that the surface passes through store numbers. A Cloud is a value; copies
// share their voxels.
#pragma once

#include <cloudcontact/base/mass_properties.h>
#include <cloudcontact/base/pose.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace cloudcontact {

constexpr int kBrickEdge = 8;                                       // voxels
constexpr int kBrickVoxels = kBrickEdge * kBrickEdge * kBrickEdge;  // 512
constexpr std::int32_t kEmptyBrick = -1;                            // all coverage 0
constexpr std::int32_t kSolidBrick = -2;                            // all coverage 255

// Coverage of a brick's voxels in 1/255, x fastest: index = x + 8 (y + 8 z).
using BrickCoverage = std::array<std::uint8_t, kBrickVoxels>;

// Indices into Voxels::materials, in the same order.
using BrickMaterial = std::array<std::uint8_t, kBrickVoxels>;

// Numbers of voxels by kind (paper, Fig. 4 b, c, d).
struct VoxelCounts {
  std::size_t inside = 0;     // coverage 255
  std::size_t interface = 0;  // 1..254
};

class Cloud {
 public:
  // The voxels of one body. Never changed once a Cloud holds them.
  struct Voxels {
    Eigen::Vector3i bricks = Eigen::Vector3i::Zero();  // bricks along each axis
    std::vector<std::int32_t>
        table;  // per brick, x fastest: index into `coverage`, or kEmptyBrick or kSolidBrick
    std::vector<BrickCoverage> coverage;
    // Bodies of several materials (paper, Fig. 4 d): the names, and per brick of `table` an index
    // into `material`, or -1 - m where the whole brick is of material m. All three are empty for a
    // body of one material.
    std::vector<std::string> materials;
    std::vector<std::int32_t> materialTable;
    std::vector<BrickMaterial> material;
  };

  Cloud() = default;
  // `voxelSize`: edge of a voxel [m]. `origin`: lowest corner of voxel (0,0,0) in the body's frame
  // [m]. Throws std::invalid_argument where the size is not positive and finite or the tables do
  // not fit the bricks.
  Cloud(double voxelSize, const Vec3& origin, std::shared_ptr<const Voxels> voxels);

  bool empty() const { return !voxels_ || voxels_->table.empty(); }
  double voxelSize() const { return voxelSize_; }
  const Vec3& origin() const { return origin_; }
  Eigen::Vector3i bricks() const { return voxels_ ? voxels_->bricks : Eigen::Vector3i::Zero(); }
  Eigen::Vector3i size() const { return bricks() * kBrickEdge; }  // voxels along each axis
  const Voxels& voxels() const { return *voxels_; }               // not for a Cloud()
  // Of the voxels, which copies share: it tells equal clouds, and expires with the last of them.
  std::weak_ptr<const void> life() const { return voxels_; }
  // Coverage of a voxel in 1/255; 0 outside the grid.
  std::uint8_t coverage(int x, int y, int z) const;
  // Material of a voxel: index into materials(), 0 in a body of one material.
  std::uint8_t material(int x, int y, int z) const;
  const std::vector<std::string>& materials() const;
  Vec3 center(int x, int y, int z) const;  // center of a voxel, in the body's frame [m]

  // The same voxels, moved by `shift` [m] in the body's frame. Shares the voxels. Throws
  // std::invalid_argument where the shift is not finite.
  Cloud translated(const Vec3& shift) const;
  // The same voxels, larger or smaller about the frame's origin. Shares the voxels. Throws
  // std::invalid_argument where the factor is not positive and finite.
  Cloud scaled(double factor) const;

  VoxelCounts counts() const;
  // At a density of 1 kg/m^3, so `mass` equals `volume`: multiply mass and inertia by the density.
  // The material of a voxel at the surface is taken to lie on the side of its fuller neighbors.
  MassProperties massProperties() const;
  std::size_t bytes() const;  // memory held by the voxels

 private:
  double voxelSize_ = 0;
  Vec3 origin_ = Vec3::Zero();
  std::shared_ptr<const Voxels> voxels_;
};

}  // namespace cloudcontact
