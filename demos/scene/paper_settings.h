// PaperSettings from the options of --method paper.
#pragma once

#include <cloudcontact/contact/paper_body.h>

#include "io/options.h"

namespace cloudcontact::program {

// Of a body with voxels of `voxel` [m], all of which is its D. `turn`: from the axes of C and Gr to
// the cloud's. A window of --window is smooth, as the usual one is.
PaperSettings paperSettings(const PaperOptions& options, double voxel,
                            const Eigen::Quaterniond& turn = Eigen::Quaterniond::Identity());

}  // namespace cloudcontact::program
