// OpenVDB's mesh to level set, as the benchmark sees it: absent where the library was not found.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/mesh/mesh.h>

#include <memory>

class LevelSetPeer {
 public:
#ifdef CLOUDCONTACT_OPENVDB
  static constexpr bool kThere = true;
#else
  static constexpr bool kThere = false;
#endif
  // Takes the mesh over into OpenVDB's form, which is not part of what is measured.
  LevelSetPeer(const cloudcontact::Mesh& mesh, double voxelSize, int threads);
  ~LevelSetPeer();

  void build();                                         // a signed distance three voxels either way
  double volume() const;                                // [m^3]
  double distance(const cloudcontact::Vec3& at) const;  // [m], at most three voxels

 private:
  struct State;
  std::unique_ptr<State> state_;
};
