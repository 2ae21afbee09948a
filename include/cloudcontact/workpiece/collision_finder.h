// A tool's collision detection area in a workpiece: the collision voxels B, their base vectors'
// mean, which is the digital normal, the materials' stiffness and damping, and how deep it is.
// Paper, Steps 2, 4 and 5; equations (1), (2), (4), (5) and (5').
#pragma once

#include <cloudcontact/workpiece/base_vector_field.h>

#include <array>
#include <cstdint>
#include <vector>

namespace cloudcontact {

// A part of a tool that cuts better or worse than the rest.
struct CuttingPart {
  PlacedSolid area;  // in the tool's frame
  double ability =
      1;  // factor of the base vectors of the voxels in it; where parts overlap, the last
};

enum class Membership : std::uint8_t {
  Whole,  // a voxel is in D or not, as its centre is: the paper's
  Shared  // a voxel counts by how much of it lies in D: no force jumps as voxels come and go
};

// What of a tool detects, and how.
struct Detection {
  PlacedSolid area;  // D, in the tool's frame: the whole tool, or any other shape
  Membership membership = Membership::Shared;
  bool hardness = true;  // h in (5'); without it (5)
  double ability = 1;    // of the tool outside of all parts
  std::vector<CuttingPart> parts;
};

// One of B.
struct CollisionVoxel {
  VoxelIndex voxel;
  float share = 1;    // of it in D, times its coverage
  float ability = 1;  // of the tool where it is
  std::uint8_t tissue = 0;
};

// In the world's frame, metres.
struct Collision {
  std::vector<CollisionVoxel> voxels;  // B
  double count = 0;                    // n: the sum of their shares
  std::vector<double> tissueCount;     // Ne, Ni, Np ... of (1) and (2); one a tissue
  Vec3 mean = Vec3::Zero();  // F: mean base vector (5), (5'): from the workpiece to the tool
  double stiffness = 0, damping = 0;  // k (1), c (2)
  Vec3 center = Vec3::Zero();         // of the touched surface, where the force acts
  // Mean of n n^T over the touched surface, n its outward normals: how much of the material's
  // stiffness meets a motion of the tool in each direction. Trace 1; on a face all of it along n.
  Eigen::Matrix3d facing = Eigen::Matrix3d::Zero();
  double depth = 0;   // d as the tool stands: how far it is in
  double volume = 0;  // of matter in D [m^3]
  bool empty() const { return count <= 0; }
  Vec3 normal() const { return mean.norm() > 0 ? Vec3(mean.normalized()) : Vec3::Zero(); }
};

// Finds collisions; keeps its memory, so that a call after the first allocates nothing unless more
// voxels collide than ever before. The answer does not depend on `threads`, to the bit.
class CollisionFinder {
 public:
  explicit CollisionFinder(int threads = 1);
  ~CollisionFinder();
  CollisionFinder(CollisionFinder&&) noexcept;
  CollisionFinder& operator=(CollisionFinder&&) noexcept;

  // Throws std::invalid_argument where a pose is not finite or an area has no volume. No
  // collision is an empty result.
  const Collision& find(const BaseVectorField& workpiece, const Pose& workpiecePose,
                        const Detection& tool, const Pose& toolPose);
  // Of voxels found by other means (interference.h): each counts wholly; `depth` and `volume` are
  // of the voxels alone.
  const Collision& gather(const BaseVectorField& workpiece, const Pose& workpiecePose,
                          const Detection& tool, const Pose& toolPose,
                          std::span<const VoxelIndex> voxels);
  void reserve(std::size_t voxels, std::size_t tissues);

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace cloudcontact
