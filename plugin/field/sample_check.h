// Whether samples from a file fit together, before a search trusts them as indices and lengths.
#pragma once

#include "field/sample_set.h"

namespace cloudcontact {

// `size`: voxels along each axis of the field's grid. True of every set that sortSamples() makes.
bool consistent(const SampleSet& samples, const Eigen::Vector3i& size);

}  // namespace cloudcontact
