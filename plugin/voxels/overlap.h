// Where two shells pass through one column, their coverages do not simply add: see overlap.cpp.
#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace cloudcontact {

// Replaces the coverages of one column, each the exact sum over all shells of what they enclose,
// by the coverages of the shells' union. `coverage[i]` belongs to the voxel between firstCell + i
// and one more on the third axis; `corners` are the triangles, three corners each, that may pass
// through the column's unit square at (u, v). All in voxels.
void uniteShells(const std::vector<Eigen::Vector3d>& corners, double u, double v, int firstCell,
                 std::vector<double>& coverage);

}  // namespace cloudcontact
