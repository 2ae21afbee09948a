// Builds sphere trees: see sphere_tree.h.
//
// The tree is divided top down: the leaves of a node are split at their median along the longest
// side of their box. The spheres are computed bottom up: the smallest around those of the two
// children, unless one already contains the other.
#include <cloudcontact/objects/octree.h>
#include <cloudcontact/objects/sphere_tree.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "voxels/cloud_builder.h"

namespace cloudcontact {

namespace {

const double kRoot3 = std::sqrt(3.0);
// Spheres of nodes are enlarged by this factor, so that rounding leaves no leaf outside.
constexpr double kRounding = 1e-12;

}  // namespace

SphereTree::SphereTree(Kind kind, std::vector<Leaf> leaves, std::vector<std::string> materials)
    : kind_(kind), materials_(std::move(materials)), leaves_(std::move(leaves)) {
  for (const Leaf& l : leaves_) {
    if (!l.center.allFinite() || !std::isfinite(l.radius) || l.radius < 0)
      throw std::invalid_argument("sphereTree: a leaf is not finite, or its radius negative");
    if (!(l.share > 0 && l.share <= 1))
      throw std::invalid_argument("sphereTree: a leaf's share must be above 0 and at most 1");
    if (l.material > 0 && l.material >= materials_.size())
      throw std::invalid_argument("sphereTree: a leaf names no material");
  }
  if (leaves_.empty()) return;
  nodes_.reserve(2 * leaves_.size());
  build(0, leaves_.size());
}

SphereTree::SphereTree(const SphereCloud& spheres) {
  validate(spheres);
  std::vector<Leaf> leaves;
  for (std::size_t i = 0; i < spheres.centers.size(); ++i)
    leaves.push_back({spheres.centers[i], spheres.radii[i], 1,
                      spheres.material.empty() ? std::uint8_t{0} : spheres.material[i],
                      static_cast<std::uint32_t>(i)});
  *this = SphereTree(Kind::Spheres, std::move(leaves), spheres.materials);
}

SphereTree::SphereTree(const PointCloud& points) {
  validate(points);
  std::vector<Leaf> leaves;
  for (std::size_t i = 0; i < points.positions.size(); ++i) {
    const float share = points.shares.empty() ? 1.f : points.shares[i];
    if (share > 0)
      leaves.push_back({points.positions[i], 0.5 * kRoot3 * points.spacing, share,
                        points.material.empty() ? std::uint8_t{0} : points.material[i],
                        static_cast<std::uint32_t>(i)});
  }
  *this = SphereTree(Kind::Cubes, std::move(leaves), points.materials);
}

SphereTree::SphereTree(const Cloud& cloud) {
  std::vector<Leaf> leaves;
  const Octree octree(cloud);
  Eigen::AlignedBox3d all;
  all.extend(cloud.origin());
  all.extend(Vec3(cloud.origin() + cloud.voxelSize() * cloud.size().cast<double>()));
  octree.forEachIn(all, [&](const Octree::Cube& cube) {
    const double half = 0.5 * cube.edge;
    leaves.push_back(
        {cloud.origin() + cloud.voxelSize() * (cube.low.cast<double>().array() + half).matrix(),
         kRoot3 * half * cloud.voxelSize(), static_cast<float>(cube.coverage) / 255, cube.material,
         static_cast<std::uint32_t>(leaves.size())});
  });
  *this = SphereTree(Kind::Cubes, std::move(leaves), cloud.materials());
}

void SphereTree::build(std::size_t first, std::size_t last) {
  const std::size_t index = nodes_.size();
  nodes_.emplace_back();
  if (last - first == 1) {
    nodes_[index] = {leaves_[first].center, leaves_[first].radius, 0,
                     static_cast<std::uint32_t>(first)};
    return;
  }
  Eigen::AlignedBox3d box;
  for (std::size_t i = first; i < last; ++i) box.extend(leaves_[i].center);
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const std::size_t middle = first + (last - first) / 2;
  const auto at = [&](std::size_t i) { return leaves_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(first), at(middle), at(last), [axis](const Leaf& a, const Leaf& b) {
    return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis] : a.item < b.item;
  });
  build(first, middle);
  const auto second = static_cast<std::uint32_t>(nodes_.size());
  build(middle, last);
  const Node &a = nodes_[index + 1], &b = nodes_[second];
  const Vec3 between = b.center - a.center;
  const double apart = between.norm();
  Node node{a.center, a.radius, second, 0};
  if (apart + a.radius <= b.radius) {
    node.center = b.center, node.radius = b.radius;
  } else if (apart + b.radius > a.radius) {
    node.radius = 0.5 * (apart + a.radius + b.radius) * (1 + kRounding);
    node.center = a.center + (node.radius - a.radius) / apart * between;
  }
  nodes_[index] = node;
}

Cloud toCloud(const SphereTree& tree, double voxelSize) {
  if (tree.kind() == SphereTree::Kind::Spheres) {
    SphereCloud spheres;
    spheres.materials = tree.materials();
    for (const SphereTree::Leaf& l : tree.leaves()) {
      spheres.centers.push_back(l.center);
      spheres.radii.push_back(l.radius);
      if (!spheres.materials.empty()) spheres.material.push_back(l.material);
    }
    return toCloud(spheres, voxelSize);
  }
  Eigen::AlignedBox3d box;
  const auto halfEdge = [](const SphereTree::Leaf& l) { return l.radius / kRoot3; };
  for (const SphereTree::Leaf& l : tree.leaves()) {
    if (!(l.radius > 0))
      throw std::invalid_argument(
          "sphereTree: its leaves are points of a surface and have no size; make a cloud of the "
          "points themselves");
    box.extend(Vec3(l.center.array() - halfEdge(l)));
    box.extend(Vec3(l.center.array() + halfEdge(l)));
  }
  std::optional<Vec3> lattice;  // a corner of the smallest cubes
  if (!tree.empty()) lattice = box.min();
  CloudBuilder builder(cloudGrid("sphereTree", box, voxelSize, lattice), tree.materials());
  for (const SphereTree::Leaf& l : tree.leaves())
    builder.addBox(l.center.array() - halfEdge(l), l.center.array() + halfEdge(l), l.share,
                   l.material);
  return builder.build();
}

}  // namespace cloudcontact
