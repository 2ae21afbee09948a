// What every stability scene is made of, whichever method it is run by: gravity, the same solid as
// each method takes it, and how its world is set.
#pragma once

#include <memory>
#include <string>

#include "lab/stability.h"
#include "scene/world.h"

namespace cloudcontact::program::lab {

constexpr double kGravity = 9.8;  // [m/s^2]

// A primitive, or the mesh of it for methods that take meshes alone.
SceneGeometry boxFor(const Trial& trial, const Vec3& size);
SceneGeometry ballFor(const Trial& trial, double radius);
SceneGeometry cylinderFor(const Trial& trial, double radius, double length);
SceneGeometry meshNamed(const std::string& name, std::shared_ptr<const Mesh> mesh);

WorldSettings worldSettings(const Trial& trial, double voxel);

}  // namespace cloudcontact::program::lab
