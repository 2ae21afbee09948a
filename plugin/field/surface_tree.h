// SurfaceTree: the surface of a cloud as triangles in a tree of boxes, for sweeps, distances and
// drawing. Two triangles a surface voxel, with corners on the field's smoothed surface.
#pragma once

#include <cloudcontact/field/surface_field.h>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace cloudcontact {

class SurfaceTree {
 public:
  using Corners = std::array<Vec3, 3>;  // counter-clockwise seen from outside
  // Triangles `first` to `first` + `count`; count 0: children `first` and `first` + 1.
  struct Node {
    Eigen::AlignedBox3f box;  // [voxels], grid's frame
    std::uint32_t first = 0, count = 0;
  };

  explicit SurfaceTree(const SurfaceField& field);

  std::size_t size() const { return triangles_.size(); }
  std::size_t bytes() const;
  // In the body's frame [m].
  Corners corners(std::uint32_t triangle) const;
  const Node& node(std::uint32_t i) const { return nodes_[i]; }  // 0: the root
  Eigen::AlignedBox3d boxOf(const Node& node) const;             // body's frame [m]

  // Calls visit(triangle) for the triangles of leaves with bound(box) < limit, near ones first:
  // `bound` is a number for a box that is less in larger boxes. visit() may lower `limit`.
  template <typename Bound, typename Visit>
  void search(const Bound& bound, const double& limit, const Visit& visit) const {
    std::pair<double, std::uint32_t> stack[kDeepest];
    int depth = 0;
    stack[depth++] = {bound(boxOf(nodes_[0])), 0};
    while (depth > 0) {
      const auto [least, at] = stack[--depth];
      if (!(least < limit)) continue;
      const Node& node = nodes_[at];
      for (std::uint32_t i = 0; i < node.count; ++i) visit(node.first + i);
      if (node.count > 0) continue;
      std::pair<double, std::uint32_t> near{bound(boxOf(nodes_[node.first])), node.first};
      std::pair<double, std::uint32_t> far{bound(boxOf(nodes_[node.first + 1])), node.first + 1};
      if (far.first < near.first) std::swap(near, far);
      if (far.first < limit) stack[depth++] = far;
      if (near.first < limit) stack[depth++] = near;
    }
  }

 private:
  static constexpr int kDeepest = 80;               // levels, by halves of 2^32 triangles, and some
  using Triangle = std::array<Eigen::Vector3f, 3>;  // [voxels], grid's frame

  void divide(std::uint32_t node);

  Vec3 origin_;
  double voxel_;
  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

// The field's tree. The first call makes it; calls may come from several threads.
const SurfaceTree& surfaceTree(const SurfaceField& field);

}  // namespace cloudcontact
