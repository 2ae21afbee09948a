// Merges and splits cubes: see octree.h.
//
// The tree is built bottom up: eight equal cubes become one, so no memory is used for cubes that
// will be merged. A change descends one path, splits the cubes on it down to the voxel and merges
// on its way back. Unused groups of eight are kept for later splits.
#include <cloudcontact/objects/octree.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "base/grid_index.h"
#include "voxels/cloud_builder.h"

namespace cloudcontact {

using Eigen::Vector3i;

Octree::Octree(const Cloud& cloud)
    : voxelSize_(cloud.voxelSize()),
      origin_(cloud.origin()),
      bricks_(cloud.bricks()),
      edge_(kBrickEdge),
      materials_(cloud.materials()) {
  if (cloud.empty()) return;
  while (edge_ < size().maxCoeff()) edge_ *= 2;
  nodes_.emplace_back();
  const Node root = made(cloud, Vector3i::Zero(), edge_);
  nodes_[0] = root;
}

Octree::Node Octree::made(const Cloud& cloud, const Vector3i& low, int edge) {
  if (!insideGrid(low, cloud.size())) return {};
  const auto [x, y, z] = std::tuple(low[0], low[1], low[2]);
  if (edge == 1) {
    const std::uint8_t c = cloud.coverage(x, y, z);
    return {-1, c, c > 0 ? cloud.material(x, y, z) : std::uint8_t{0}};
  }
  if (edge == kBrickEdge) {
    const Cloud::Voxels& voxels = cloud.voxels();
    const std::size_t entry = brickIndex(low, bricks_);
    if (voxels.table[entry] == kEmptyBrick) return {};
    if (voxels.table[entry] == kSolidBrick &&
        (materials_.empty() || voxels.materialTable[entry] < 0))
      return {-1, 255, cloud.material(x, y, z)};
  }
  Node eight[8];
  for (int k = 0; k < 8; ++k) eight[k] = made(cloud, low + edge / 2 * corner(k), edge / 2);
  return joined(eight);
}

// The parent of eight nodes: a leaf where all are equal, otherwise the owner of their group.
Octree::Node Octree::joined(const Node (&eight)[8]) {
  if (std::all_of(eight + 1, eight + 8, [&](const Node& n) { return n.alike(eight[0]); }))
    return eight[0];
  std::int32_t group;
  if (!free_.empty()) {
    group = free_.back();
    free_.pop_back();
  } else {
    if (nodes_.size() + 8 > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
      throw std::length_error("octree: more than 2^31 cubes; choose a larger voxelSize");
    group = static_cast<std::int32_t>(nodes_.size());
    nodes_.resize(nodes_.size() + 8);
  }
  std::copy(eight, eight + 8, nodes_.begin() + group);
  return {group, 0, 0};
}

Octree::Cube Octree::at(const Vector3i& voxel) const {
  if (empty() || !insideGrid(voxel, size())) return {voxel, 1, 0, 0};
  std::size_t node = 0;
  Vector3i low = Vector3i::Zero();
  int edge = edge_;
  while (nodes_[node].children >= 0) {
    edge /= 2;
    int k = 0;
    for (int axis = 0; axis < 3; ++axis)
      if (voxel[axis] >= low[axis] + edge) low[axis] += edge, k |= 1 << axis;
    node = nodes_[node].children + k;
  }
  return {low, edge, nodes_[node].coverage, nodes_[node].material};
}

void Octree::set(const Vector3i& voxel, std::uint8_t coverage, std::uint8_t material) {
  if (empty() || !insideGrid(voxel, size()))
    throw std::invalid_argument("octree: voxel is outside the grid; make the cloud with room");
  if (material > 0 && material >= materials_.size())
    throw std::invalid_argument("octree: material is not an index into materials()");
  setBelow(0, voxel, edge_, {-1, coverage, coverage > 0 ? material : std::uint8_t{0}});
}

void Octree::setBelow(std::size_t node, const Vector3i& voxel, int edge, const Node& value) {
  if (nodes_[node].alike(value)) return;
  if (edge == 1) {
    nodes_[node] = value;
    return;
  }
  if (nodes_[node].children < 0) {  // split into eight copies
    Node eight[8];
    std::fill(eight, eight + 8, nodes_[node]);
    if (free_.empty()) {
      free_.push_back(static_cast<std::int32_t>(nodes_.size()));
      nodes_.resize(nodes_.size() + 8);
    }
    const std::int32_t group = free_.back();
    free_.pop_back();
    std::copy(eight, eight + 8, nodes_.begin() + group);
    nodes_[node].children = group;
  }
  const int half = edge / 2;
  const Vector3i side = (voxel.array() >= half).cast<int>();
  const std::int32_t group = nodes_[node].children;
  setBelow(group + side[0] + 2 * side[1] + 4 * side[2], voxel - half * side, half, value);
  const Node* eight = nodes_.data() + group;
  if (!std::all_of(eight + 1, eight + 8, [&](const Node& n) { return n.alike(eight[0]); })) {
    nodes_[node].coverage = nodes_[node].material = 0;
    return;
  }
  nodes_[node] = eight[0];
  free_.push_back(group);
}

Cloud Octree::cloud() const {
  if (empty()) return {};
  auto voxels = emptyVoxels(bricks_, materials_);
  BrickCoverage coverage;
  BrickMaterial material;
  for (std::size_t entry = 0; entry < voxels->table.size(); ++entry) {
    const Vector3i low = kBrickEdge * gridCell(entry, bricks_);
    const Cube whole = at(low);
    coverage.fill(whole.coverage);
    material.fill(whole.material);
    for (int v = 0; v < kBrickVoxels && whole.edge < kBrickEdge; ++v) {
      const Cube cube = at(Vector3i(low + cellOffset(v)));
      coverage[v] = cube.coverage;
      material[v] = cube.material;
    }
    storeBrick(*voxels, entry, coverage, materials_.empty() ? nullptr : &material);
  }
  return Cloud(voxelSize_, origin_, std::move(voxels));
}

std::size_t Octree::cubes() const {
  // Each group of eight takes the place of one leaf.
  return empty() ? 0 : 1 + 7 * ((nodes_.size() - 1) / 8 - free_.size());
}

std::size_t Octree::bytes() const {
  return nodes_.capacity() * sizeof(Node) + free_.capacity() * sizeof(std::int32_t);
}

bool Octree::sameBelow(std::size_t node, const Octree& other, std::size_t there) const {
  const Node &a = nodes_[node], &b = other.nodes_[there];
  if (a.children < 0 || b.children < 0) return a.alike(b);
  for (int k = 0; k < 8; ++k)
    if (!sameBelow(a.children + k, other, b.children + k)) return false;
  return true;
}

bool Octree::operator==(const Octree& other) const {
  if (empty() || other.empty()) return empty() == other.empty();
  return voxelSize_ == other.voxelSize_ && origin_ == other.origin_ && bricks_ == other.bricks_ &&
         materials_ == other.materials_ && sameBelow(0, other, 0);
}

}  // namespace cloudcontact
