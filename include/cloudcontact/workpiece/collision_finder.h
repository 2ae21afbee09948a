// The collision of a tool with a workpiece: the collision voxels B inside the tool's collision
// detection area D, the mean of their base vectors, which is the digital normal, the stiffness and
// damping of their tissues, and the depth. Paper, Steps 2, 4 and 5; equations (1), (2), (4), (5)
// and (5').
#pragma once

#include <cloudcontact/base/span.h>
#include <cloudcontact/contact/paper_body.h>
#include <cloudcontact/field/base_vector_field.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace cloudcontact {

// How Collision::depth is measured.
enum class DepthTo : std::uint8_t {
  Tip,     // how far D reaches below the surface along the digital normal: for tools of any shape
  Nearest  // to D's nearest surface: of 4 voxels a needle reads 2.1, but while a tool cuts its own
           // hole the depth changes smoothly
};

// How a tool detects.
struct Detection {
  PlacedSolid area;  // D, in the tool's frame: the whole tool, or any other shape
  Membership membership = Membership::Shared;
  // h in (5'); without it (5). Where h or the ability is 0 in all collision voxels, F is (5) too:
  // material that is cut freely, or touched by a part that does not cut, still pushes back.
  bool hardness = true;
  double ability = 1;  // of the tool outside all parts
  std::vector<CuttingPart> parts;
  DepthTo depth = DepthTo::Tip;
};

// One element of B.
struct CollisionVoxel {
  VoxelIndex voxel;
  float share = 1;          // inside D, times its coverage; 1 with Membership::Whole and gather()
  float ability = 1;        // of the tool at the voxel
  std::uint8_t tissue = 0;  // index into BaseVectorField::tissues()
};

// In the world's frame.
struct Collision {
  std::vector<CollisionVoxel> voxels;  // B
  double count = 0;                    // n: the sum of the shares
  std::vector<double> tissueCount;     // Ne, Ni, Np ... of (1) and (2), one per tissue
  Vec3 mean = Vec3::Zero();    // F: mean base vector (5), (5'), from the workpiece to the tool [m]
  double stiffness = 0;        // k (1) [N/m]
  double damping = 0;          // c (2) [N s/m]
  Vec3 center = Vec3::Zero();  // of the touched surface, where the force acts [m]
  // Mean of n n^T over the touched surface, n its outward normals: the share of the material's
  // stiffness that resists a motion of the tool in each direction. Trace 1; on a face all along n.
  Eigen::Matrix3d facing = Eigen::Matrix3d::Zero();
  // d of the tool where it is now [m]: how far it reaches below the surface along the digital
  // normal, which is how far it must move along it to come out. (With DepthTo::Tip.)
  double depth = 0;
  double volume = 0;  // of material in D [m^3]
  bool empty() const { return count <= 0; }
  Vec3 normal() const { return mean.norm() > 0 ? Vec3(mean.normalized()) : Vec3::Zero(); }
};

// Finds collisions. Keeps its memory: after the first call it allocates only where more voxels
// collide than before. Results do not depend on the number of threads, to the bit.
class CollisionFinder {
 public:
  explicit CollisionFinder(int threads = 1);
  ~CollisionFinder();
  CollisionFinder(CollisionFinder&&) noexcept;
  CollisionFinder& operator=(CollisionFinder&&) noexcept;

  // Throws std::invalid_argument where a pose is not finite or an area has no volume. Without a
  // collision the result is empty. It is valid until the next call.
  const Collision& find(const BaseVectorField& workpiece, const Pose& workpiecePose,
                        const Detection& tool, const Pose& toolPose);
  // The collision of given voxels (interference.h), whatever the membership. Each counts as one;
  // `depth` and `volume` are those of their matter alone.
  const Collision& gather(const BaseVectorField& workpiece, const Pose& workpiecePose,
                          const Detection& tool, const Pose& toolPose,
                          Span<const VoxelIndex> voxels);
  // Allocates for collisions of up to so many voxels.
  void reserve(std::size_t voxels, std::size_t tissues);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
