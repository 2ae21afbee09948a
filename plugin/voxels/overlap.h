// Coverage of columns that several shells pass through: see overlap.cpp.
#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace cloudcontact {

// Replaces the coverages of one column, each the sum over all shells, by those of the shells'
// union. `coverage[i]` belongs to cell firstCell + i of the third axis; `corners` are the
// triangles, three corners each, that may pass through the column's unit square at (u, v). All in
// voxels.
void uniteShells(const std::vector<Eigen::Vector3d>& corners, double u, double v, int firstCell,
                 std::vector<double>& coverage);

}  // namespace cloudcontact
