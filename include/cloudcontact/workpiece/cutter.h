// Cutting: a tool removes voxels where its cutting ability exceeds their hardness, at a rate set by
// force and speed (paper, Step 3: cutting ability and cutting difficulty).
#pragma once

#include <cloudcontact/workpiece/collision_finder.h>

namespace cloudcontact {

// Archard's law of abrasion (J. Appl. Phys. 24, 1953): the volume removed is
// efficiency * force * distance / hardness, with the distance that the cutting edges move over the
// material.
struct Cutter {
  // Of the tool [Pa]; 17 GPa is tungsten carbide. Times the tool's ability at a voxel, it must
  // exceed the voxel's hardness, or nothing is removed.
  double hardness = 17e9;
  double efficiency = 0.1;  // share of the plowed volume that comes off, at most 1
  double edgeSpeed = 0;     // of the edges, by the spindle; the tool's motion adds to it [m/s]
  // Most voxels that one step changes. Beyond that, every second, third ... voxel also takes the
  // share of its neighbors. Otherwise soft tissue would go all at once, at the cost of the whole
  // tick.
  int mostVoxels = 500;
  // Leaves the part of a voxel that lies outside the tool's area, so that a groove is no wider than
  // its tool (WorldCutter). Without it voxels that the tool grazes are ground away in time, and the
  // force changes more smoothly.
  bool keepsOutside = false;
};

// The cuts of a tool that nothing resists, for BaseVectorField::cut(), cutCloud() and
// CuttableBody::cut(): of each voxel that the area meets, the part outside the area remains, by the
// depth of the voxel's center (Membership::Shared). `area` is in the tool's frame, `tool` is the
// tool's pose in the workpiece's frame. Throws std::invalid_argument where the area has no volume
// or the pose is not finite.
std::vector<VoxelCut> cutsOf(const BaseVectorField& workpiece, const PlacedSolid& area,
                             const Pose& tool);
// The same of a cloud that has no field.
std::vector<VoxelCut> cutsOf(const Cloud& workpiece, const PlacedSolid& area, const Pose& tool);

// Removes material from a collision's voxels, from each by its share, ability and hardness. Carries
// less than 1/255 of a voxel over to the next step, so that slow cutting also cuts. Does not
// allocate after a call with as many voxels.
class CuttingProcess {
 public:
  // Throws std::invalid_argument where a value of the cutter is negative or not finite, or
  // mostVoxels is not positive.
  explicit CuttingProcess(const Cutter& cutter);

  // What a step has taken off.
  struct Cut {
    std::size_t voxels = 0;  // that changed
    double volume = 0;       // [m^3]
  };
  // Cuts for `seconds` under `force` [N], with the tool sliding at `speed` [m/s].
  Cut step(BaseVectorField& workpiece, const Collision& collision, double force, double speed,
           double seconds);
  // The voxels that the last step changed, as they are now.
  const std::vector<VoxelCut>& last() const { return cuts_; }
  void reserve(std::size_t voxels) { cuts_.reserve(voxels); }

 private:
  Cutter cutter_;
  double carry_ = 0;      // not yet removed [1/255 voxel]
  std::size_t turn_ = 0;  // number of steps
  std::vector<VoxelCut> cuts_;
};

}  // namespace cloudcontact
