// What of a body can be drawn: its meshes, and its voxels where it is a cloud. Shared with the
// world that simulates it; nothing is copied.
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
  std::shared_ptr<const Mesh> mesh;  // none for an endless plane
  Pose pose;                         // of the mesh in the body's frame
  std::optional<Vec3> planeNormal;   // through the part's origin, in the part's frame
};

// Voxels as the contact sees them.
struct DrawnCloud {
  std::shared_ptr<const SurfaceField> field;
  Pose pose;  // of the grid in the body's frame
};

struct DrawnBody {
  std::vector<DrawnPart> parts;
  std::vector<DrawnCloud> clouds;

  bool isPlane() const {
    return std::all_of(parts.begin(), parts.end(),
                       [](const DrawnPart& part) { return part.planeNormal.has_value(); });
  }
};

}  // namespace cloudcontact::program
