// Which voxel is of which material, in a body made of several meshes.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <string>

namespace cloudcontact {

// Fills in a body's materials, one mesh after the other.
class Materials {
 public:
  explicit Materials(Cloud::Voxels& body) : body_(body) {}

  // `own`: the mesh's voxels in the body's grid. Of each voxel it claims those of whose matter it
  // has at least half, whoever claimed them before.
  void add(const std::string& name, const Cloud::Voxels& own);

 private:
  void claim(std::size_t entry, const BrickCoverage& own, std::uint8_t material);
  Cloud::Voxels& body_;
};

}  // namespace cloudcontact
