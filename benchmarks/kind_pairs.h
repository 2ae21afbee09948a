// Collision voxels by other digital kinds than voxels: what the benchmark `kinds` compares.
#pragma once

#include <cloudcontact/objects/digital_object.h>
#include <cloudcontact/voxels/voxel_cut.h>

#include <algorithm>
#include <vector>

namespace cloudcontact {

using FoundVoxels = std::vector<VoxelIndex>;

// All sorted, each voxel once. `place`: the tool's frame in the workpiece's.
FoundVoxels pointsInOctree(const PointCloud& tool, const Pose& place, const Octree& work);
FoundVoxels pointsInVoxels(const PointCloud& tool, const Pose& place, const Cloud& work);
FoundVoxels columnsInColumns(const ColumnCloud& tool, const Pose& place, const ColumnCloud& work);
FoundVoxels treeInTree(const SphereTree& tool, const Pose& place, const SphereTree& workTree,
                       const Cloud& work);
FoundVoxels treeInColumns(const SphereTree& tool, const Pose& place, const ColumnCloud& columns,
                          const Cloud& work);

// The half edge of a leaf that is a cube [m].
double halfEdge(const SphereTree::Leaf& leaf);

// Calls visit(leaf) for every leaf whose sphere is nearer than `reach` to a point [m].
template <typename Visit>
void forEachNear(const SphereTree& tree, const Vec3& point, double reach, Visit&& visit,
                 std::size_t node = 0) {
  const SphereTree::Node& n = tree.nodes()[node];
  if ((n.center - point).squaredNorm() > (n.radius + reach) * (n.radius + reach)) return;
  if (n.second == 0) return visit(tree.leaves()[n.leaf]);
  forEachNear(tree, point, reach, visit, node + 1);
  forEachNear(tree, point, reach, visit, n.second);
}

}  // namespace cloudcontact
