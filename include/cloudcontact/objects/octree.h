// Octree: a cloud as cubes of several sizes, eight merged into one wherever coverage and material
// are the same (paper, step 1 and Fig. 3). Conversion to a cloud and back is exact. It suits bodies
// that are cut: set() changes one voxel in place, along a path of at most 15 cubes, and forEachIn()
// visits only the cubes in a box.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <string>
#include <vector>

namespace cloudcontact {

class Octree {
 public:
  // A cube of equal voxels.
  struct Cube {
    Eigen::Vector3i low;        // its lowest voxel
    int edge = 1;               // voxels, a power of two
    std::uint8_t coverage = 0;  // 1/255
    std::uint8_t material = 0;  // index into materials(); 0 where empty
  };

  Octree() = default;  // empty, as Cloud()
  explicit Octree(const Cloud& cloud);

  bool empty() const { return nodes_.empty(); }
  double voxelSize() const { return voxelSize_; }  // [m]
  const Vec3& origin() const { return origin_; }   // lowest corner of voxel (0,0,0) [m]
  Eigen::Vector3i bricks() const { return bricks_; }
  Eigen::Vector3i size() const { return bricks_ * kBrickEdge; }  // voxels
  int edge() const { return edge_; }                             // of the largest cube, voxels
  const std::vector<std::string>& materials() const { return materials_; }

  // The cube around a voxel. Outside the grid: an empty cube of one voxel.
  Cube at(const Eigen::Vector3i& voxel) const;

  // Calls visit(const Cube&) for every cube with material that touches the box (body's frame [m]),
  // in a fixed order. Allocates nothing.
  template <typename Visit>
  void forEachIn(const Eigen::AlignedBox3d& box, Visit&& visit) const {
    if (empty() || box.isEmpty()) return;
    const Vec3 low = (box.min() - origin_) / voxelSize_, high = (box.max() - origin_) / voxelSize_;
    walk(0, Eigen::Vector3i::Zero(), edge_, low, high, visit);
  }

  // Sets a voxel, splitting and merging the cubes around it: the tree equals that of the changed
  // cloud. Throws std::invalid_argument outside the grid and where `material` is not an index into
  // materials().
  void set(const Eigen::Vector3i& voxel, std::uint8_t coverage, std::uint8_t material = 0);

  Cloud cloud() const;

  std::size_t cubes() const;  // number of leaves, with and without material
  std::size_t bytes() const;  // memory in use
  // Equal cubes at equal places; their order in memory does not matter.
  bool operator==(const Octree& other) const;

 private:
  struct Node {
    std::int32_t children = -1;  // index of the first of eight; -1: a leaf
    std::uint8_t coverage = 0, material = 0;
    bool alike(const Node& other) const {
      return children < 0 && other.children < 0 && coverage == other.coverage &&
             material == other.material;
    }
  };
  static Eigen::Vector3i corner(int k) { return {k & 1, k >> 1 & 1, k >> 2}; }
  Node made(const Cloud& cloud, const Eigen::Vector3i& low, int edge);
  Node joined(const Node (&eight)[8]);
  void setBelow(std::size_t node, const Eigen::Vector3i& voxel, int edge, const Node& value);
  bool sameBelow(std::size_t node, const Octree& other, std::size_t there) const;

  template <typename Visit>
  void walk(std::size_t node, const Eigen::Vector3i& low, int edge, const Vec3& boxLow,
            const Vec3& boxHigh, Visit& visit) const {
    const Node& n = nodes_[node];
    if (n.children < 0 && n.coverage == 0) return;
    if ((low.cast<double>().array() > boxHigh.array()).any() ||
        (low.cast<double>().array() + edge < boxLow.array()).any())
      return;
    if (n.children < 0) return visit(Cube{low, edge, n.coverage, n.material});
    for (int k = 0; k < 8; ++k)
      walk(n.children + k, low + edge / 2 * corner(k), edge / 2, boxLow, boxHigh, visit);
  }

  double voxelSize_ = 0;
  Vec3 origin_ = Vec3::Zero();
  Eigen::Vector3i bricks_ = Eigen::Vector3i::Zero();
  int edge_ = 0;
  std::vector<std::string> materials_;
  std::vector<Node> nodes_;         // the first is the root, then groups of eight
  std::vector<std::int32_t> free_;  // groups of eight that merges left unused
};

}  // namespace cloudcontact
