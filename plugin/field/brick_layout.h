// Lays out a BaseVectorField: which bricks have a block of their own, and what their voxels hold.
// The sums of the windows follow, here or on a device.
#pragma once

#include "field/base_vector_bricks.h"

namespace cloudcontact {

// A field's grid and its materials (empty: one without a name).
struct FieldGrid {
  double voxelSize = 0;  // [m]
  Vec3 origin = Vec3::Zero();
  Eigen::Vector3i bricks = Eigen::Vector3i::Zero();
  std::vector<std::string> materials;
};

// All that does not depend on the voxels; the blocks are the shared ones. Throws as BaseVectorField
// does.
std::unique_ptr<BaseVectorBricks> startBricks(const FieldGrid& grid, const TissueTable& tissues,
                                              const WindowSettings& window);
// Sums up the voxels of the blocks.
void sumTissues(BaseVectorBricks& field);
// The rest, once the table and the blocks are filled.
void finishBricks(BaseVectorBricks& field);

// All but the sums of blocks of a single brick. Throws as BaseVectorField does.
std::unique_ptr<BaseVectorBricks> layOutBricks(const Cloud& cloud, const TissueTable& tissues,
                                               const WindowSettings& window);

// Table entries of the bricks with blocks of their own, in the order of the blocks.
std::vector<std::int32_t> ownBricks(const BaseVectorBricks& field);

// Mass properties from sums by the tissues' densities, in the body's frame.
MassProperties massOf(const BaseVectorBricks& field, const std::vector<MatterSums>& sums);

// The window for kernels/digitize/window_sums.h.
std::vector<CcWindowTap> windowTaps(const Window& window);

// Sums the windows of all blocks of a single brick, on all cores.
void sumWindows(BaseVectorBricks& field);

}  // namespace cloudcontact
