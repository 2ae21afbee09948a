// Laying out a BaseVectorField: which brick has a block of its own, and what its voxels hold. The
// windows' sums come after, here or on a device.
#pragma once

#include "field_bricks.h"

namespace cloudcontact {

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

// The tissues' sums, of the voxels as they are.
void sumTissues(BaseVectorField::Bricks& field);

}  // namespace cloudcontact
