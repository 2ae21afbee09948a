// LevelError: how far the surface of a coarse field is from the voxels of a finer cloud of the same
// body. No field of the finer cloud is needed: a voxel's coverage tells where a plane with the
// coarse field's normal cuts it.
#pragma once

#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/voxels/cloud.h>

#include <vector>

namespace cloudcontact {

class LevelError {
 public:
  LevelError() = default;  // no error anywhere
  LevelError(const SurfaceField& coarse, const Cloud& fine);
  static LevelError unseen();  // infinite everywhere

  double most() const { return most_; }  // [m]; may be infinite
  // In the coarse bricks that `region` (body's frame [m]) touches.
  double in(const Eigen::AlignedBox3d& region) const;
  std::size_t bytes() const { return bricks_.capacity() * sizeof(float); }

 private:
  Vec3 origin_ = Vec3::Zero();
  double brick_ = 0;  // [m] edge
  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();
  std::vector<float> bricks_;  // [m]
  double most_ = 0;
};

// Where a plane cuts a unit cube so that a share of it, 0..1, lies inside: the depth of the cube's
// center below the plane. `normal`: a unit vector, any signs.
double depthByCoverage(const Vec3& normal, double share);

}  // namespace cloudcontact
