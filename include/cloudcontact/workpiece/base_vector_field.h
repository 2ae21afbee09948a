// BaseVectorField: a workpiece (the paper's object 2) that may be cut. Every voxel of it knows how
// much matter lies in its cuttable area C and where that matter's centre of gravity Gc is, so its
// base vector Gr - Gc (4) is a division away. All sums are of integers: when matter goes, only the
// voxels whose C it lay in change, and what results equals a field built anew, to the bit.
//
// A body that only touches others has a SurfaceField instead, which is finer and does not change.
#pragma once

#include <cloudcontact/law/tissue.h>
#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/voxels/voxel_cut.h>
#include <cloudcontact/workpiece/window.h>

#include <memory>
#include <optional>
#include <span>

namespace cloudcontact {

// A voxel's window, weighed. Lengths in metres, the body's frame.
struct BaseVector {
  Vec3 toRepresentative = Vec3::Zero();  // Gr - Gc (4), without h (5')
  double fraction = 0;                   // of C that is matter, 0..1, by volume
};

class BaseVectorField {
 public:
  // `tissues`: one for each of the cloud's materials, or one for all of it. Throws
  // std::invalid_argument where the cloud is empty, their number is another or a value is not
  // usable; as makeWindow() does.
  BaseVectorField(const Cloud& cloud, const TissueTable& tissues, const WindowSettings& window);
  ~BaseVectorField();
  BaseVectorField(BaseVectorField&&) noexcept;
  BaseVectorField& operator=(BaseVectorField&&) noexcept;

  double voxelSize() const;
  const Vec3& origin() const;    // the lowest corner of voxel (0,0,0) [m]
  Eigen::Vector3i size() const;  // voxels along each axis
  const TissueTable& tissues() const;
  const Window& window() const;

  // Of voxels outside the grid: 0, the first tissue, nothing.
  std::uint8_t coverage(const VoxelIndex& v) const;
  int tissue(const VoxelIndex& v) const;  // index into tissues()
  BaseVector at(const VoxelIndex& v) const;
  // Signed depth of the voxel's centre below the surface, told from its window's fraction by a
  // table for planes (DESIGN.md, "The method", 3) [m]; never more than the window reaches. Empty
  // where the window sees no matter.
  std::optional<double> depth(const VoxelIndex& v) const;

  // Takes matter away: what would add some is left as it is. Voxels may come in any order and more
  // than once. Allocates nothing where `reserve` was called; returns how many voxels changed.
  // Throws std::out_of_range where a voxel is outside the grid, before anything is changed.
  std::size_t cut(std::span<const VoxelCut> voxels);
  // Memory for all bricks that a cut could ever touch [each 22 kB]: for loops that must not wait.
  void reserve();

  // Of all material, by the densities of the tissues, in the body's frame. From integer sums: exact
  // for the voxels as they are.
  MassProperties mass() const;

  // The voxels as they are now.
  Cloud cloud() const;
  // A number that two fields share only if they hold the same: for tests and for networks.
  std::uint64_t hash() const;
  std::size_t bytes() const;

  // The bricks as a query walks them (plugin/contact/field_bricks.h).
  struct Bricks;
  const Bricks& bricks() const { return *bricks_; }
  explicit BaseVectorField(std::unique_ptr<Bricks> bricks);  // whole, as a device gives them back
  std::unique_ptr<Bricks> takeBricks() &&;  // as a device takes them; the field is none after that

 private:
  std::unique_ptr<Bricks> bricks_;
};

}  // namespace cloudcontact
