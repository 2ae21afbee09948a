// A body as users name it: a mesh file, a file of points, a saved cloud, or a primitive.
#pragma once

#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/law/solid.h>
#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/objects/digital_object.h>
#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/voxels/digitize.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/options.h"

namespace cloudcontact::program {

// Exactly one of the four is there: what the specification named.
struct Body {
  std::string name;              // as typed
  std::optional<Mesh> mesh;      // of a file, in metres
  std::vector<NamedMesh> parts;  // of that mesh, where it has several
  std::optional<Solid> shape;    // a primitive or the half-space z < 0
  std::optional<Cloud> cloud;    // of a .cloud file of voxels
  // Of a file of points, in metres, or of a .cloud file of any other kind.
  std::optional<DigitalObject> object;
};

// Reads `specification`: sphere:R, box:X,Y,Z (full edges), cylinder:R,H, capsule:R,H and cone:R,H
// (axis z; a capsule's H is between its caps' centres), halfspace (z < 0), a .cloud file, a file of
// points (PLY without faces, PCD, XYZ) or a mesh file. Throws BadInput naming it.
Body readBody(const std::string& specification, const CommonOptions& options);

bool isHalfSpace(const Body& body);
// Lowest and highest corner in the body's frame [m].
Eigen::AlignedBox3d boundsOf(const Body& body);
// A voxel for those who name none: a saved cloud's own, a hundredth of the body's diagonal, for
// points not less than two of their distances. [m]
double defaultVoxel(const Body& body);

struct DigitizedBody {
  Cloud cloud;
  bool closed = true;              // the mesh's every edge belonged to two faces
  Backend backend = Backend::Cpu;  // that digitised it
};

// The body as a cloud: a mesh digitised (a sheet as a shell, with a message on stderr; parts as
// materials named after them), a primitive
// by way of its mesh, a saved cloud as it is, points as what they are found to be (a message on
// stderr says it): a volume, a closed surface, a shell where --shell is given. Throws BadInput for
// a half-space, a voxel that does not fit in memory, or a saved cloud of another voxel size than
// the one asked for. With --backend opencl a device digitises a mesh of one material, where it can;
// a message on stderr says why it does not.
DigitizedBody digitizeBody(const Body& body, double voxel, const CommonOptions& options);

// The cloud's field, with a progress bar. Throws BadInput naming the body.
std::shared_ptr<const SurfaceField> buildField(const Cloud& cloud, const std::string& name,
                                               const CommonOptions& options);

// The body as a mesh; facets of a primitive within `tolerance` [m]. Throws BadInput where it is a
// half-space, a saved cloud or points.
Mesh meshOf(const Body& body, double tolerance);

}  // namespace cloudcontact::program
