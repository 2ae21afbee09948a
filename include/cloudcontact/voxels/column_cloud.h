// ColumnCloud: a body as columns along an axis, each with the intervals that hold material. A
// Z-buffer that keeps every layer gives such rectangular parallelepipeds (paper, step 1 and
// Fig. 4 a).
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>

#include <string>
#include <vector>

namespace cloudcontact {

// An interval of one column. `share` is the part of the cross-section that is material: in a
// Z-buffer it is always 1, which moves walls along the columns by up to half a column.
struct ColumnInterval {
  double low = 0, high = 0;   // [m] along the axis, from the origin
  float share = 1;            // of the cross-section, above 0 and at most 1
  std::uint8_t material = 0;  // index into ColumnCloud::materials
};

struct ColumnCloud {
  int axis = 2;                                       // of the columns: 0 x, 1 y, 2 z
  double width = 0;                                   // [m] edge of a column's square
  Vec3 origin = Vec3::Zero();                         // [m] lowest corner of column 0, body's frame
  Eigen::Vector2i columns = Eigen::Vector2i::Zero();  // along u = axis + 1 and v = axis + 2
  // Column u + columns[0] v has intervals first[c] .. first[c + 1], ascending, not overlapping.
  std::vector<std::size_t> first;
  std::vector<ColumnInterval> intervals;
  std::vector<std::string> materials;  // empty for one material
};

// Throws std::invalid_argument that names the first rule above that does not hold.
void validate(const ColumnCloud& columns);

// The columns of a cloud, `perVoxel` along a voxel's edge. toCloud() with the cloud's voxelSize
// gives the cloud back, to 1/255. Throws std::invalid_argument where the axis is not 0, 1 or 2 or
// perVoxel is not in 1..64.
ColumnCloud toColumns(const Cloud& cloud, int axis = 2, int perVoxel = 4);

// The columns of a mesh, `width` [m] wide. An interval ends at the mean height of the surface over
// the column, to 1/510 of the width. Throws as digitize() does.
ColumnCloud toColumns(const Mesh& mesh, double width, int axis = 2);

// The voxels of columns, with exact coverage. Where voxelSize is a multiple of the width, faces of
// voxels lie on faces of columns. Throws std::invalid_argument where the columns are empty or the
// size is not positive, std::length_error where the voxels would need too much memory.
Cloud toCloud(const ColumnCloud& columns, double voxelSize);

// Kinds of voxels (paper, Fig. 4 b, c, d): full, empty, and crossed by the surface.
enum class VoxelKind : std::uint8_t { Inside, Outside, Interface };
// Of a voxel; outside the grid it is Outside.
VoxelKind kindOf(const Cloud& cloud, const Eigen::Vector3i& voxel);

// All voxels of a cloud by kind, in the order of the bricks.
struct VoxelSplit {
  std::vector<Eigen::Vector3i> inside, interface;
  std::size_t outside = 0;  // number of the others
};
// The voxels of a cloud by kind.
VoxelSplit splitVoxels(const Cloud& cloud);

}  // namespace cloudcontact
