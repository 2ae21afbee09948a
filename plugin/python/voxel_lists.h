// Lists of voxels from arrays of Python.
#pragma once

#include <cloudcontact/voxels/voxel_cut.h>

#include <vector>

#include "python/numpy_views.h"

namespace cloudcontact::python {

// From an array (n, 3) of integers. Throws std::invalid_argument.
std::vector<VoxelIndex> voxelsFrom(const py::object& voxels);
// `coverage`: one number for each voxel or one for all [1/255]; None: 0. Throws
// std::invalid_argument.
std::vector<VoxelCut> cutsFrom(const py::object& voxels, const py::object& coverage);

}  // namespace cloudcontact::python
