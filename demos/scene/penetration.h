// Penetration depth of bodies, measured on their meshes and primitives, independent of the
// simulated method.
#pragma once

#include <memory>
#include <variant>
#include <vector>

#include "scene/mesh_distance.h"
#include "scene/scene.h"

namespace cloudcontact::program {

// A solid in closed form, or a mesh's distance.
using MeasuredSolid = std::variant<SceneBox, SceneSphere, SceneCylinder, SceneCapsule, SceneCone,
                                   ScenePlane, std::shared_ptr<const MeshDistance>>;

// Depth of a point in the solid's frame: positive inside, minus the distance outside [m]. For
// `reach` see MeshDistance::depth.
double depthIn(const MeasuredSolid& solid, const Vec3& point, double reach);

// A point on a solid's surface, or the center of an inscribed ball for round solids.
struct Probe {
  Vec3 position = Vec3::Zero();
  double radius = 0;
};

// Probes that lie together, and a ball that holds them with theirs.
struct ProbeBlock {
  Vec3 center = Vec3::Zero();
  double radius = 0;
  std::size_t first = 0, count = 0;
};

// One solid with the probes for its depth in others. Shared by equal bodies.
struct Probed {
  MeasuredSolid solid;
  std::vector<Probe> probes;       // block by block
  std::vector<ProbeBlock> blocks;  // most of them are nowhere near another body
};
// `mesh` gives the probes of a box, cylinder or cone, and the solid of a mesh geometry.
std::shared_ptr<const Probed> probed(const SceneGeometry& geometry, const Mesh* mesh);

// A body: solids at poses in its frame.
struct MeasuredBody {
  struct Part {
    std::shared_ptr<const Probed> what;
    Pose pose;
  };
  std::vector<Part> parts;
};

// Largest depth of either body's probes in the other; 0 if they are apart [m].
double penetration(const MeasuredBody& a, const Pose& poseA, const MeasuredBody& b,
                   const Pose& poseB);

// Number of probes of a body, the cost of measuring it.
std::size_t probeCount(const MeasuredBody& body);

}  // namespace cloudcontact::program
