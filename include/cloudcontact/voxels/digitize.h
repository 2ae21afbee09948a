// From a mesh to a cloud: depth columns along an axis, cut into voxels (paper, step 1 and Fig. 4).
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>

#include <functional>
#include <vector>

namespace cloudcontact {

struct DigitizeSettings {
  double voxelSize = 0;                         // [m], must be set
  std::size_t maxBytes = std::size_t{4} << 30;  // refuse, with a size that would fit, beyond this
  int threads = 0;                              // 0: all cores
  std::function<void(double)> progress;         // called with 0..1, may be empty
};

// What became of a mesh on its way to voxels.
struct DigitizeReport {
  bool closed = false;  // the surface had no boundary, once welded and mended
  // Columns in which the surface did not close by itself: a filling of its holes closed it, or,
  // where much is missing, the other axes were asked.
  std::size_t badColumns = 0;
  std::size_t undecidedVoxels = 0;  // voxels that columns left open, judged by winding number
};

// Throws std::invalid_argument on a bad setting or a mesh without volume, std::length_error where
// the voxels would need more than maxBytes: the message says how much, and the size that fits.
Cloud digitize(const Mesh& mesh, const DigitizeSettings& settings,
               DigitizeReport* report = nullptr);

// A body of several materials: meshes that lie within one another or side by side, each of the
// material that it is named after. The body is all of them together; a voxel is of the smallest
// mesh that has at least half of the voxel's matter. Meshes that bound no volume of their own (a
// half of a shell whose other half is another mesh) leave their part to the largest. A cloud
// with fewer than two meshes that bound a volume has no materials. Throws as above, and where there
// is no mesh or more than 256.
Cloud digitize(const std::vector<NamedMesh>& meshes, const DigitizeSettings& settings,
               DigitizeReport* report = nullptr);

// An upper bound of the memory that digitising would hold, before anything is allocated [bytes].
std::size_t digitizeBytes(const Mesh& mesh, double voxelSize);

}  // namespace cloudcontact
