// Bodies of the stability scenes, in the form that each method takes, and the settings of a trial's
// world.
#pragma once

#include <memory>
#include <string>

#include "lab/stability.h"
#include "scene/world.h"

namespace cloudcontact::program::lab {

constexpr double kGravity = 9.8;  // [m/s^2]

// A primitive for clouds and Bullet's own shapes, its mesh for methods that only take meshes.
SceneGeometry boxFor(const Trial& trial, const Vec3& size);
SceneGeometry ballFor(const Trial& trial, double radius);
SceneGeometry cylinderFor(const Trial& trial, double radius, double length);
SceneGeometry meshNamed(const std::string& name, std::shared_ptr<const Mesh> mesh);

// Static where mass is 0. Bodies of one `kind` share one mesh.
SceneBody meshBody(const std::string& kind, std::shared_ptr<const Mesh> mesh, const Pose& pose,
                   double mass, double friction);
SceneBody boxBody(const Trial& trial, const Vec3& size, const Pose& pose, double mass,
                  double friction);
SceneBody sphereBody(const Trial& trial, double radius, const Pose& pose, double mass,
                     double friction);
SceneBody floorBody(double friction);  // z <= 0

// Stiffness and damping of a pair. Each body states twice as much, since two springs act in series.
struct Spring {
  double stiffness = 0;  // [N/m]
  double damping = 0;    // [N s/m]
};
// The spring that sags by `sag` [m] under `load` [kg], with damping ratio 1 for a body of `mass`.
Spring springFor(double mass, double load, double sag);

// Mass and contact properties of a body. Stiffness and damping are those of its pairs with bodies
// that state none; only the mode "stiff" uses them.
struct Matter {
  double mass = 0;  // [kg], 0: static
  double friction = 0.5;
  double stiffness = 0;  // [N/m], 0: not stated
  double damping = 0;    // [N s/m]
};
// Damping from a damping ratio.
Matter springMatter(double mass, double friction, double stiffness, double ratio);

bool isStiff(const Trial& trial);
// Adds a body with a model of its own to `scene`: bodies of one model do not collide.
SceneBody& addBody(SceneDescription& scene, const std::string& name, const SceneGeometry& geometry,
                   const Vec3& position, const Matter& matter, const Trial& trial);
SceneBody& addPlane(SceneDescription& scene, double friction);

// Depth of a pair at rest that carries `force` [m].
double sagOf(const Trial& trial, const Matter& matter, double force, double voxel);

WorldSettings worldSettings(const Trial& trial, double voxel);

}  // namespace cloudcontact::program::lab
