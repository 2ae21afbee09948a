// ColumnCloud: a body as rectangular parallelepipeds, columns along an axis with the intervals in
// which they hold material: what a Z-buffer that keeps every layer stores (paper, step 1 and
// Fig. 4 a).
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>

#include <string>
#include <vector>

namespace cloudcontact {

// A stretch of one column. A Z-buffer's column is all material or none; here a wall along the
// columns may take part of one's cross-section, and `share` says which part: without it a wall
// would be off by half a column's width.
struct ColumnInterval {
  double low = 0, high = 0;   // [m] along the axis, from the origin
  float share = 1;            // of the column's cross-section
  std::uint8_t material = 0;  // index into ColumnCloud::materials
};

struct ColumnCloud {
  int axis = 2;                                       // columns run along it: 0 x, 1 y, 2 z
  double width = 0;                                   // [m] edge of a column's square
  Vec3 origin = Vec3::Zero();                         // [m] lowest corner of column 0, body's frame
  Eigen::Vector2i columns = Eigen::Vector2i::Zero();  // along u = axis + 1 and v = axis + 2
  // Column u + columns[0] v has intervals first[c] .. first[c + 1], ascending, not overlapping.
  std::vector<std::size_t> first;
  std::vector<ColumnInterval> intervals;
  std::vector<std::string> materials;  // empty for one material
};

// Throws std::invalid_argument that names what does not hold of the above.
void validate(const ColumnCloud& columns);

// `perVoxel` columns along a voxel's edge. The material of every voxel stays what it is: toCloud
// with the cloud's voxelSize gives the cloud back, to 1/255. Throws std::invalid_argument where the
// axis is not 0, 1 or 2 or perVoxel not in 1..64.
ColumnCloud toColumns(const Cloud& cloud, int axis = 2, int perVoxel = 4);

// From a mesh, columns `width` [m] wide: an interval's end is the mean height of the surface over
// the column, not one ray's, to 1/510 of the width. Throws as digitize does.
ColumnCloud toColumns(const Mesh& mesh, double width, int axis = 2);

// Voxels from columns, each with the exact part of the columns that it cuts out. Where voxelSize is
// a multiple of the width, voxels' faces lie on columns' faces. Throws std::invalid_argument where
// there is nothing or the size is not positive, std::length_error where it takes too much memory.
Cloud toCloud(const ColumnCloud& columns, double voxelSize);

// The voxels of Fig. 4 b, c and d: inside the body, no part of it, and its interface.
enum class VoxelKind : std::uint8_t { Inside, Outside, Interface };
VoxelKind kindOf(const Cloud& cloud, const Eigen::Vector3i& voxel);
struct VoxelSplit {
  std::vector<Eigen::Vector3i> inside, interface;
  std::size_t outside = 0;  // the rest of the grid
};
VoxelSplit splitVoxels(const Cloud& cloud);

}  // namespace cloudcontact
