// A body from the command line: a mesh file, a point file, a volume, a saved cloud, or a primitive.
#pragma once

#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/law/solid.h>
#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/objects/digital_object.h>
#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/voxels/ct_volume.h>
#include <cloudcontact/voxels/digitize.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "io/options.h"

namespace cloudcontact::program {

// Exactly one of mesh, shape, cloud, object and volume is set.
struct Body {
  std::string name;              // as typed
  std::optional<Mesh> mesh;      // from a file, in meters
  std::vector<NamedMesh> parts;  // of the mesh, if it has several
  std::optional<Solid> shape;    // a primitive or the half-space z < 0
  std::optional<Cloud> cloud;    // of a .cloud file of voxels
  // From a point file, in meters, or from a .cloud file of another kind than voxels.
  std::optional<DigitalObject> object;
  std::optional<CtVolume> volume;  // grey values of a CT scan
};

// Reads `specification`: a primitive (readPrimitive), a .cloud file, a point file (PLY without
// faces, PCD, XYZ), a volume (NRRD, MetaImage) or a mesh file. Throws BadInput naming it.
Body readBody(const std::string& specification, const CommonOptions& options);
// Throws BadInput where --threshold is given and none of the specifications is a volume.
void checkThresholds(const CommonOptions& options, const std::vector<std::string>& specifications);

// A mesh of more parts than this is one material.
inline constexpr std::size_t kMostParts = 32;

bool isHalfSpace(const Body& body);
// Axis-aligned box in the body's frame [m].
Eigen::AlignedBox3d boundsOf(const Body& body);
// Default voxel size [m]: a saved cloud's own, suggestedVoxel() of a mesh, else a hundredth of the
// body's diagonal; for points at least twice their spacing; a volume's smallest spacing.
double defaultVoxel(const Body& body);

struct DigitizedBody {
  Cloud cloud;
  bool closed = true;              // every edge of the mesh belongs to two faces
  Backend backend = Backend::Cpu;  // that did the work
};

// The body as a cloud. A mesh is digitized: a sheet as a shell, parts as materials of their names.
// A primitive is digitized from its mesh. A saved cloud is returned as it is. Points become a
// filled volume, the inside of a closed surface, or a shell. A volume has material from the values
// of --threshold on. With --backend opencl a device
// digitizes meshes of one material. Messages on stderr report shells, the kind of points, and why
// no device is used. Throws BadInput for a half-space, a grid that does not fit in memory, or a
// saved cloud of another voxel size than --voxel.
DigitizedBody digitizeBody(const Body& body, double voxel, const CommonOptions& options);

// The body as a solid: a primitive by its formula, all else by its cloud. Throws BadInput as
// digitizeBody() does.
PlacedSolid solidOf(const Body& body, double voxel, const CommonOptions& options);

// Builds the cloud's field and shows progress. Throws BadInput naming the body.
std::shared_ptr<const SurfaceField> buildField(const Cloud& cloud, const std::string& name,
                                               const CommonOptions& options);

// The body as a mesh; a primitive's facets lie within `tolerance` [m]. Throws BadInput for a
// half-space, a saved cloud or points.
Mesh meshOf(const Body& body, double tolerance);

// What a refusal of this mesh for its size may add: whether it is in millimeters. Empty where that
// would not explain it.
std::string unitHint(const Mesh& mesh, double voxel);

// Runs the work on a mesh that was read in units of `unit` meters. Where they are meters, it adds
// the hint to std::length_error.
template <typename Work>
auto askingUnit(const Mesh& mesh, double voxel, double unit, const Work& work) {
  try {
    return work();
  } catch (const std::length_error& refused) {
    throw std::length_error(refused.what() + (unit == 1 ? unitHint(mesh, voxel) : ""));
  }
}

}  // namespace cloudcontact::program
