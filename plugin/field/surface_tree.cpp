// Marching cubes (display_mesh.h) leave corners up to 0.1 voxel off a slanted face; the field's
// depth moves them onto it.
#include "field/surface_tree.h"

#include <cloudcontact/voxels/display_mesh.h>

#include <algorithm>

#include "field/field_data.h"
#include "field/smoothed_point.h"

namespace cloudcontact {

namespace {

constexpr std::uint32_t kLeaf = 4;     // triangles
constexpr double kCornerMoves = 0.75;  // [voxels] that a corner is moved
constexpr float kNoArea = 1e-6f;       // [voxels^2]

Eigen::Vector3f ontoSurface(const SurfaceField& field, const Eigen::Vector3f& corner) {
  const Cloud& cloud = field.cloud();
  const Vec3 local = cloud.origin() + cloud.voxelSize() * corner.cast<double>();
  const auto own = field.at(local);
  if (!own) return corner;
  const FieldPoint point = smoothedPoint(field, local, *own);
  const Vec3 move = point.depth / cloud.voxelSize() * point.normal;
  if (!(move.norm() < kCornerMoves)) return corner;
  return corner + move.cast<float>();
}

Eigen::Vector3f acrossOf(const std::array<Eigen::Vector3f, 3>& t) {
  return (t[1] - t[0]).cross(t[2] - t[0]);
}

}  // namespace

SurfaceTree::SurfaceTree(const SurfaceField& field)
    : origin_(field.cloud().origin()), voxel_(field.cloud().voxelSize()) {
  const DisplayMesh mesh(field.cloud(), 1);
  std::vector<Eigen::Vector3f> moved;
  for (int b = 0; b < mesh.bricks(); ++b) {
    const DisplayBrick* const brick = mesh.brick(b);
    if (!brick) continue;
    moved.clear();
    for (const Eigen::Vector3f& v : brick->vertices) moved.push_back(ontoSurface(field, v));
    for (const Eigen::Vector3i& t : brick->triangles) {
      const auto of = [&t](const std::vector<Eigen::Vector3f>& v) {
        return Triangle{v[std::size_t(t[0])], v[std::size_t(t[1])], v[std::size_t(t[2])]};
      };
      const Triangle flat = of(brick->vertices), on = of(moved);
      const bool turned = acrossOf(flat).dot(acrossOf(on)) <= 0;  // over an edge
      const Triangle& best = turned ? flat : on;
      if (acrossOf(best).norm() > kNoArea) triangles_.push_back(best);
    }
  }
  nodes_.reserve(triangles_.size());
  Node& root = nodes_.emplace_back();
  root.count = static_cast<std::uint32_t>(triangles_.size());
  divide(0);
}

void SurfaceTree::divide(std::uint32_t at) {
  const std::uint32_t first = nodes_[at].first, count = nodes_[at].count;
  Eigen::AlignedBox3f box, middles;
  const auto middleOf = [](const Triangle& t) { return Eigen::Vector3f(t[0] + t[1] + t[2]); };
  for (std::uint32_t i = first; i < first + count; ++i) {
    for (const Eigen::Vector3f& corner : triangles_[i]) box.extend(corner);
    middles.extend(middleOf(triangles_[i]));
  }
  nodes_[at].box = box;
  if (count <= kLeaf) return;
  Eigen::Index axis = 0;
  middles.sizes().maxCoeff(&axis);
  const std::uint32_t half = count / 2;
  const auto begin = triangles_.begin() + first;
  std::nth_element(begin, begin + half, begin + count, [&](const Triangle& x, const Triangle& y) {
    return middleOf(x)[axis] < middleOf(y)[axis];
  });
  const auto child = static_cast<std::uint32_t>(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  nodes_[at].first = child;
  nodes_[at].count = 0;
  nodes_[child].first = first, nodes_[child].count = half;
  nodes_[child + 1].first = first + half, nodes_[child + 1].count = count - half;
  divide(child);
  divide(child + 1);
}

std::size_t SurfaceTree::bytes() const {
  return triangles_.size() * sizeof(Triangle) + nodes_.size() * sizeof(Node);
}

SurfaceTree::Corners SurfaceTree::corners(std::uint32_t triangle) const {
  Corners corners;
  for (std::size_t k = 0; k < 3; ++k)
    corners[k] = origin_ + voxel_ * triangles_[triangle][k].cast<double>();
  return corners;
}

Eigen::AlignedBox3d SurfaceTree::boxOf(const Node& node) const {
  return {Vec3(origin_ + voxel_ * node.box.min().cast<double>()),
          Vec3(origin_ + voxel_ * node.box.max().cast<double>())};
}

const SurfaceTree& surfaceTree(const SurfaceField& field) {
  LazySurfaceTree& lazy = field.data().lazyTree();
  std::call_once(lazy.once, [&] { lazy.made = std::make_shared<const SurfaceTree>(field); });
  return *lazy.made;
}

}  // namespace cloudcontact
