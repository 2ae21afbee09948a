// Materials: the material of each voxel in a body of several meshes.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <string>

namespace cloudcontact {

// Assigns materials to a body's voxels, mesh after mesh.
class Materials {
 public:
  explicit Materials(Cloud::Voxels& body) : body_(body) {}

  // `own`: the voxels of the material's mesh in the body's grid. Voxels of whose material it holds
  // at least half become its own, also those that an earlier mesh claimed.
  void add(const std::string& name, const Cloud::Voxels& own);

 private:
  void claim(std::size_t entry, const BrickCoverage& own, std::uint8_t material);
  Cloud::Voxels& body_;
};

}  // namespace cloudcontact
