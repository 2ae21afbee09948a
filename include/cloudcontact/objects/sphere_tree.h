// SphereTree: the hierarchical sphere model (HSM) of points, spheres or voxels (paper, I and
// step 1). Each node's sphere encloses its children's, so that what is near a place is found
// without asking the rest.
#pragma once

#include <cloudcontact/objects/point_cloud.h>
#include <cloudcontact/objects/sphere_cloud.h>

#include <string>
#include <vector>

namespace cloudcontact {

class SphereTree {
 public:
  // What the leaves are: spheres themselves, or cubes (a voxel, what a point stands for) within
  // their circumscribed sphere.
  enum class Kind : std::uint8_t { Spheres, Cubes };

  struct Leaf {
    Vec3 center = Vec3::Zero();  // [m]
    double radius = 0;           // [m] a cube's edge is 2 radius / sqrt(3)
    float share = 1;             // of it that is material
    std::uint8_t material = 0;
    std::uint32_t item = 0;  // which point or sphere it was made of; of a cloud: its number here
  };

  // A sphere around all that is below. Children of node i are i + 1 and `second`; a node without
  // has one leaf.
  struct Node {
    Vec3 center = Vec3::Zero();  // [m]
    double radius = 0;           // [m]
    std::uint32_t second = 0;    // 0: none
    std::uint32_t leaf = 0;      // index into leaves(), where there are no children
  };

  SphereTree() = default;
  // Points stand for cubes of their spacing; those of a surface, which have none, for themselves.
  explicit SphereTree(const PointCloud& points);
  explicit SphereTree(const SphereCloud& spheres);
  // A leaf a voxel with material; full ones merged to the octree's cubes.
  explicit SphereTree(const Cloud& cloud);
  // From leaves as they are, in any order. Throws std::invalid_argument where one is not finite,
  // its radius negative, its share not in (0, 1] or its material not there.
  SphereTree(Kind kind, std::vector<Leaf> leaves, std::vector<std::string> materials = {});

  bool empty() const { return nodes_.empty(); }
  Kind kind() const { return kind_; }
  const std::vector<Node>& nodes() const { return nodes_; }
  const std::vector<Leaf>& leaves() const { return leaves_; }
  const std::vector<std::string>& materials() const { return materials_; }

  // Calls visit(const Leaf&) for every leaf whose sphere touches a sphere or a box [m], in a fixed
  // order. Holds no memory.
  template <typename Visit>
  void forEachTouching(const Vec3& center, double radius, Visit&& visit) const {
    const auto touches = [&](const Vec3& c, double r) {
      return (c - center).squaredNorm() <= (r + radius) * (r + radius);
    };
    if (!empty()) walk(0, touches, visit);
  }
  template <typename Visit>
  void forEachTouching(const Eigen::AlignedBox3d& box, Visit&& visit) const {
    const auto touches = [&](const Vec3& c, double r) {
      return box.squaredExteriorDistance(c) <= r * r;
    };
    if (!empty() && !box.isEmpty()) walk(0, touches, visit);
  }

 private:
  void build(std::size_t first, std::size_t last);

  template <typename Touches, typename Visit>
  void walk(std::size_t node, const Touches& touches, Visit& visit) const {
    const Node& n = nodes_[node];
    if (!touches(n.center, n.radius)) return;
    if (n.second == 0) return visit(leaves_[n.leaf]);
    walk(node + 1, touches, visit);
    walk(n.second, touches, visit);
  }

  Kind kind_ = Kind::Spheres;
  std::vector<std::string> materials_;
  std::vector<Leaf> leaves_;  // in the order of the tree
  std::vector<Node> nodes_;
};

// The leaves' bodies as voxels: spheres as toCloud(SphereCloud) does, cubes each with its share.
// Throws as that does, and where leaves have no size.
Cloud toCloud(const SphereTree& tree, double voxelSize);

}  // namespace cloudcontact
