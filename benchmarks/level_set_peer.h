// OpenVDB's meshToLevelSet; a stub without OpenVDB.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/mesh/mesh.h>

#include <memory>

class LevelSetPeer {
 public:
#ifdef CLOUDCONTACT_OPENVDB
  static constexpr bool kAvailable = true;
#else
  static constexpr bool kAvailable = false;
#endif
  // Converts the mesh for OpenVDB, which is not timed.
  LevelSetPeer(const cloudcontact::Mesh& mesh, double voxelSize, int threads);
  ~LevelSetPeer();

  void build();                                         // signed distances up to three voxels
  double volume() const;                                // [m^3]
  double distance(const cloudcontact::Vec3& at) const;  // [m], clamped to three voxels

 private:
  struct State;
  std::unique_ptr<State> state_;
};
