// DisplayMesh: a cloud's surface as triangles to look at, where coverage passes a half. Kept brick
// by brick, so that after a cut only the bricks that it touched are made anew, and a viewer uploads
// no others.
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace cloudcontact {

// The triangles of one brick. Vertices in voxels, in the grid's frame (voxel (0,0,0) spans
// [0,1]^3): they stay where they are when a cut moves the body's frame. Vertices on the border of
// two bricks are in both, equal to the bit.
struct DisplayBrick {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Eigen::Vector3i> triangles;  // counter-clockwise seen from outside
  std::vector<std::uint8_t> materials;     // of each triangle: index into Cloud::materials()
};

class DisplayMesh {
 public:
  // threads 0: all cores. Throws std::invalid_argument on an empty cloud.
  explicit DisplayMesh(const Cloud& cloud, int threads = 0);

  // Becomes the mesh of a cloud in the same grid, equal to one made anew; what was equal before is
  // not looked at. Returns the numbers of the bricks that were made anew, rising. Throws
  // std::invalid_argument where the grid is another.
  std::vector<int> renew(const Cloud& after);

  const Cloud& cloud() const { return cloud_; }
  int bricks() const { return static_cast<int>(bricks_.size()); }
  // Null where there is no surface. Pointers stay until the brick is made anew.
  const DisplayBrick* brick(int number) const {
    return bricks_[static_cast<std::size_t>(number)].get();
  }
  // All bricks in one mesh, in the cloud's frame [m], one brick's vertices after another's; closed
  // where vertices in the same place are taken for one. `materials`, if given: of each triangle.
  Mesh mesh(std::vector<std::uint8_t>* materials = nullptr) const;

 private:
  void make(const std::vector<int>& numbers);

  Cloud cloud_;
  int threads_;
  std::vector<std::unique_ptr<const DisplayBrick>> bricks_;
};

}  // namespace cloudcontact
