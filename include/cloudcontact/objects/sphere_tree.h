// SphereTree: the hierarchical sphere model (HSM) of points, spheres or voxels (paper, section I
// and step 1). The sphere of a node encloses those of its children. Bodies collide as voxels, which
// are faster (docs/method.md, "Step 2: interference").
#pragma once

#include <cloudcontact/objects/point_cloud.h>
#include <cloudcontact/objects/sphere_cloud.h>

#include <string>
#include <vector>

namespace cloudcontact {

class SphereTree {
 public:
  // Leaves are spheres, or cubes (voxels, points that fill a volume) in their circumscribed
  // spheres.
  enum class Kind : std::uint8_t { Spheres, Cubes };

  // A sphere or a cube with matter.
  struct Leaf {
    Vec3 center = Vec3::Zero();  // [m]
    double radius = 0;           // [m]; the edge of a cube is 2 radius / sqrt(3)
    float share = 1;             // fraction that is material
    std::uint8_t material = 0;
    std::uint32_t item = 0;  // index of its point or sphere; for a cloud: number of the leaf
  };

  // A sphere around everything below. The children of node i are i + 1 and `second`; a node without
  // children has one leaf.
  struct Node {
    Vec3 center = Vec3::Zero();  // [m]
    double radius = 0;           // [m]
    std::uint32_t second = 0;    // 0: none
    std::uint32_t leaf = 0;      // index into leaves(), for a node without children
  };

  SphereTree() = default;
  // Points that fill a volume become cubes of their spacing, points of a surface cubes of edge 0.
  // Throws as validate(PointCloud) does.
  explicit SphereTree(const PointCloud& points);
  // Throws as validate(SphereCloud) does.
  explicit SphereTree(const SphereCloud& spheres);
  // One leaf per voxel with material; full voxels are merged to the cubes of the octree.
  explicit SphereTree(const Cloud& cloud);
  // From leaves in any order. Throws std::invalid_argument where one is not finite, has a negative
  // radius, a share outside (0, 1] or an index without a material.
  SphereTree(Kind kind, std::vector<Leaf> leaves, std::vector<std::string> materials = {});

  bool empty() const { return nodes_.empty(); }
  Kind kind() const { return kind_; }
  const std::vector<Node>& nodes() const { return nodes_; }
  const std::vector<Leaf>& leaves() const { return leaves_; }
  const std::vector<std::string>& materials() const { return materials_; }

 private:
  void build(std::size_t first, std::size_t last);

  Kind kind_ = Kind::Spheres;
  std::vector<std::string> materials_;
  std::vector<Leaf> leaves_;  // in the order of the tree
  std::vector<Node> nodes_;
};

// The union of the leaves as voxels: spheres as toCloud(SphereCloud) does, cubes with their shares.
// Throws as that does, and std::invalid_argument where leaves have no size.
Cloud toCloud(const SphereTree& tree, double voxelSize);

}  // namespace cloudcontact
