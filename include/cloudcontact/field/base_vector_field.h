// A workpiece (the paper's object 2) that may be cut. Each voxel knows how much material lies in
// its cuttable area C and where that material's center of gravity Gc is, so its base vector
// Gr - Gc (4) takes one division (docs/method.md, "Step 5: direction"). All sums are of integers: a
// cut changes only the voxels whose C it touches, and the result equals a field built from the cut
// cloud, to the bit.
//
// A body that is never cut has a SurfaceField instead, which is finer.
#pragma once

#include <cloudcontact/base/mass_properties.h>
#include <cloudcontact/base/span.h>
#include <cloudcontact/field/window.h>
#include <cloudcontact/law/tissue.h>
#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/voxels/voxel_cut.h>

#include <memory>
#include <optional>

namespace cloudcontact {

struct BaseVectorBricks;
struct OwnedVectorCache;

// Lengths in meters, in the body's frame.
struct BaseVector {
  Vec3 toRepresentative = Vec3::Zero();  // Gr - Gc (4), without the hardness h of (5')
  double fraction = 0;                   // share of C that is material, by volume
};

class BaseVectorField {
 public:
  // `tissues`: one for each of the cloud's materials, or one for all. Throws std::invalid_argument
  // where the cloud is empty, the number of tissues does not fit or a value is not valid, and as
  // makeWindow() does.
  BaseVectorField(const Cloud& cloud, const TissueTable& tissues, const WindowSettings& window);
  ~BaseVectorField();
  BaseVectorField(BaseVectorField&&) noexcept;
  BaseVectorField& operator=(BaseVectorField&&) noexcept;

  double voxelSize() const;      // [m]
  const Vec3& origin() const;    // the lowest corner of voxel (0,0,0) [m]
  Eigen::Vector3i size() const;  // voxels along each axis
  const TissueTable& tissues() const;
  const Window& window() const;

  // Voxels outside the grid have coverage 0, the first tissue and an empty window.
  std::uint8_t coverage(const VoxelIndex& v) const;  // [1/255]
  int tissue(const VoxelIndex& v) const;             // index into tissues()
  BaseVector at(const VoxelIndex& v) const;
  // Signed depth of the voxel's center below the surface, looked up by how full its window is
  // (docs/engine.md, "Depth from the window") [m]. Its range is that of the window. Empty where the
  // window holds no material.
  std::optional<double> depth(const VoxelIndex& v) const;

  // Removes material; entries that would add material are ignored. Voxels may come in any order
  // and more than once. Returns the number of voxels that changed. Does not allocate after
  // reserve(). Throws std::out_of_range where a voxel lies outside the grid, before any change.
  std::size_t cut(Span<const VoxelCut> voxels);
  // Allocates all bricks that cuts could ever change, 22 kB each, for loops that must not wait.
  void reserve();

  // Removes all material but that of a part of the body. `part` has the body's grid and nowhere
  // more matter. Faster than cut(), as bricks that the part has no matter in go whole. Throws
  // std::invalid_argument if the part is empty or its grid is another.
  void keepPart(const Cloud& part);
  // The field of a part, as keepPart() leaves it: in a twentieth of the time of making it.
  BaseVectorField ofPart(const Cloud& part) const;

  // Of all material, by the tissues' densities, in the body's frame. From integer sums: exact for
  // the voxels as they are.
  MassProperties mass() const;

  // The voxels as they are now.
  Cloud cloud() const;
  // A checksum: two fields with the same contents have the same one.
  std::uint64_t hash() const;
  std::size_t bytes() const;  // of memory

  // For the library's own loops and devices (plugin/field/base_vector_bricks.h). After
  // takeBricks() the field is empty and must not be used.
  using Bricks = BaseVectorBricks;
  const Bricks& bricks() const;
  OwnedVectorCache& owned() const;  // plugin/field/owned_vector_cache.h
  explicit BaseVectorField(std::unique_ptr<Bricks> bricks);
  std::unique_ptr<Bricks> takeBricks() &&;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
