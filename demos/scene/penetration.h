// How deep bodies stand in each other, measured on their meshes and primitives rather than by the
// method that a simulation runs on.
#pragma once

#include <memory>
#include <variant>
#include <vector>

#include "scene/mesh_distance.h"
#include "scene/scene.h"

namespace cloudcontact::program {

// A solid of a body: a closed form, or a mesh's distance.
using MeasuredSolid = std::variant<SceneBox, SceneSphere, SceneCylinder, SceneCapsule, ScenePlane,
                                   std::shared_ptr<const MeshDistance>>;

// Depth of a point in a solid, in the solid's frame: positive inside, minus the distance outside
// [m]; see MeshDistance::depth for `reach`.
double depthIn(const MeasuredSolid& solid, const Vec3& point, double reach);

// A point of a solid's surface, or, for what is round, the middle of a ball in it.
struct Probe {
  Vec3 position = Vec3::Zero();
  double radius = 0;
};

// One solid and the probes that stand for it when it enters others. Shared by equal bodies.
struct Probed {
  MeasuredSolid solid;
  std::vector<Probe> probes;
};
// `mesh` serves the probes of a box or cylinder, and the solid where there is none of its own.
std::shared_ptr<const Probed> probed(const SceneGeometry& geometry, const Mesh* mesh);

// A body: solids at places in its frame.
struct MeasuredBody {
  struct Part {
    std::shared_ptr<const Probed> what;
    Pose pose;
  };
  std::vector<Part> parts;
};

// The deepest that probes of either body stand in the other; 0 where they are apart [m].
double penetration(const MeasuredBody& a, const Pose& poseA, const MeasuredBody& b,
                   const Pose& poseB);

// How many probes a body has: what measuring costs.
std::size_t probeCount(const MeasuredBody& body);

}  // namespace cloudcontact::program
