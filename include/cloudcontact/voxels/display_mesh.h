// DisplayMesh: the surface of a cloud as triangles for viewers, at a coverage of one half. It is
// stored brick by brick: after a cut only the affected bricks are rebuilt and uploaded.
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace cloudcontact {

// The triangles of one brick. Vertices are in voxels, in the grid's frame (voxel (0,0,0) spans
// [0,1]^3), so they keep their values when a cut moves the body's frame. Vertices on the border of
// two bricks are in both, equal to the bit.
struct DisplayBrick {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Eigen::Vector3i> triangles;  // counter-clockwise seen from outside
  std::vector<std::uint8_t> materials;     // per triangle: index into Cloud::materials()
};

class DisplayMesh {
 public:
  // threads 0: all cores. Throws std::invalid_argument on an empty cloud.
  explicit DisplayMesh(const Cloud& cloud, int threads = 0);

  // Updates the mesh to another cloud in the same grid. The result equals a new DisplayMesh; only
  // bricks whose voxels differ are rebuilt. Returns their numbers in ascending order. Throws
  // std::invalid_argument where the grid or the materials differ.
  std::vector<int> renew(const Cloud& after);

  const Cloud& cloud() const { return cloud_; }
  int bricks() const { return static_cast<int>(bricks_.size()); }
  // Null where there is no surface. The pointer is valid until the brick is rebuilt.
  const DisplayBrick* brick(int number) const { return bricks_[number].get(); }
  // All bricks as one mesh in the cloud's frame [m], brick after brick. It is closed once equal
  // vertices are welded. `materials`, where not null, receives the material of each triangle.
  Mesh mesh(std::vector<std::uint8_t>* materials = nullptr) const;

 private:
  void make(const std::vector<int>& numbers);

  Cloud cloud_;
  int threads_;
  std::vector<std::unique_ptr<const DisplayBrick>> bricks_;
};

}  // namespace cloudcontact
