// The drawable parts of a body: its meshes, and the voxels of its clouds. Shared with the world,
// not copied.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/mesh/mesh.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

namespace cloudcontact::program {

struct DrawnPart {
  std::shared_ptr<const Mesh> mesh;  // null for an infinite plane
  Pose pose;                         // of the mesh in the body's frame
  std::optional<Vec3> planeNormal;   // through the part's origin, in the part's frame
};

// Voxels that the contact method uses.
struct DrawnCloud {
  std::shared_ptr<const SurfaceField> field;
  Pose pose;  // of the grid in the body's frame
};

// Empty for a body that is cut, whose surface changes (World::matter).
struct DrawnBody {
  std::vector<DrawnPart> parts;
  std::vector<DrawnCloud> clouds;

  bool isPlane() const {
    return !parts.empty() && std::all_of(parts.begin(), parts.end(), [](const DrawnPart& part) {
      return part.planeNormal.has_value();
    });
  }
};

}  // namespace cloudcontact::program
