// Laying out a BaseVectorField: which brick has a block of its own, and what its voxels hold. The
// windows' sums come after, here or on a device.
#pragma once

#include "workpiece/base_vector_bricks.h"

namespace cloudcontact {

// Where a field's voxels lie, and the materials that they may be of (none: of one).
struct FieldGrid {
  double voxelSize = 0;  // [m]
  Vec3 origin = Vec3::Zero();
  Eigen::Vector3i bricks = Eigen::Vector3i::Zero();
  std::vector<std::string> materials;
};

// All that does not depend on which voxels hold matter; the blocks are the shared ones. Throws as
// BaseVectorField does.
std::unique_ptr<BaseVectorField::Bricks> startBricks(const FieldGrid& grid,
                                                     const TissueTable& tissues,
                                                     const WindowSettings& window);
// What is left to do once the table and the blocks are there.
void finishBricks(BaseVectorField::Bricks& field);

// All but the sums of the blocks that bricks have for themselves. Throws as BaseVectorField does.
std::unique_ptr<BaseVectorField::Bricks> layOutBricks(const Cloud& cloud,
                                                      const TissueTable& tissues,
                                                      const WindowSettings& window);

// The bricks with blocks of their own, by their places in the table, in the blocks' order.
std::vector<std::int32_t> ownBricks(const BaseVectorField::Bricks& field);

// The window as kernels/window_sums.h has it.
std::vector<CcWindowTap> windowTaps(const Window& window);

// The sums of all these blocks, on all cores.
void sumWindows(BaseVectorField::Bricks& field);

}  // namespace cloudcontact
