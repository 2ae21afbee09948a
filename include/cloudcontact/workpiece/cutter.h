// What a tool takes away: voxels go when its ability outdoes their hardness, at a rate that force
// and speed set (paper, Step 3: cutting ability and cutting difficulty).
#pragma once

#include <cloudcontact/workpiece/collision_finder.h>

namespace cloudcontact {

// Archard's law of abrasion (J. Appl. Phys. 24, 1953): the volume that goes is
// efficiency * force * way / hardness, the way that of the cutting edge over the material.
struct Cutter {
  double hardness = 17e9;   // [Pa] of the tool itself; times the ability where a voxel lies, it
                            // must outdo the voxel's, or nothing goes. 17 GPa: tungsten carbide
  double efficiency = 0.1;  // of the ploughed volume, what comes off; 1 at most
  double edgeSpeed = 0;     // [m/s] of the edges, from the spindle; the tool's own motion is added
  // Voxels that one step changes at most: of more, every second, third ... takes its neighbours'
  // turn too. What is as soft as pulp would else go in one step, all that the tool is in (1,400
  // voxels, 0.8 ms).
  int mostVoxels = 500;
};

// What a tool leaves of every voxel that it lies in, where nothing withstands it: the part outside,
// told by the depth of the voxel's centre (Membership::Shared); to be handed to cut(). The area is
// given in the tool's frame, the pose is the tool's in the workpiece's frame. Throws
// std::invalid_argument where the area has no volume or the pose is not finite.
std::vector<VoxelCut> cutsOf(const BaseVectorField& workpiece, const PlacedSolid& area,
                             const Pose& tool);

// Takes matter from the collision's voxels, each by its share, ability and hardness, for `seconds`
// under `force` [N] with the tool sliding at `speed` [m/s]. What is less than 1/255 of a voxel is
// kept for the next, so that slow cutting is not lost. Allocates nothing after the first call with
// as many voxels.
class CuttingProcess {
 public:
  // Throws std::invalid_argument where a value of the cutter is negative, or not finite, or
  // mostVoxels is not positive.
  explicit CuttingProcess(const Cutter& cutter);

  struct Cut {
    std::size_t voxels = 0;  // that changed
    double volume = 0;       // [m^3]
  };
  Cut step(BaseVectorField& workpiece, const Collision& collision, double force, double speed,
           double seconds);
  // The voxels of the last step, as they are now: what else must be renewed.
  const std::vector<VoxelCut>& last() const { return cuts_; }
  void reserve(std::size_t voxels) { cuts_.reserve(voxels); }

 private:
  Cutter cutter_;
  double carry_ = 0;      // [1/255 voxel] owed
  std::size_t turn_ = 0;  // steps so far
  std::vector<VoxelCut> cuts_;
};

}  // namespace cloudcontact
