// Primitives for clouds and for Bullet's own shapes, meshes for the others.
#include "lab/trial_bodies.h"

#include <cloudcontact/law/solid.h>

#include <sstream>
#include <utility>

#include "scene/primitive_mesh.h"

namespace cloudcontact::program::lab {
namespace {

// A mesh peer's facets stay this much of a body's size off what is round.
constexpr double kRound = 1e-3;

bool takesPrimitives(const Trial& trial) {
  return trial.method == Method::Cloud || trial.method == Method::Primitive;
}

// Meshes are told apart by name, and no two sizes may share one.
SceneGeometry meshOf(const Solid& shape, double size) {
  std::ostringstream name;
  name << "shape " << shape.index() << ' ' << boundsOf(shape).max().transpose();
  return meshNamed(name.str(), std::make_shared<const Mesh>(primitiveMesh(shape, kRound * size)));
}

}  // namespace

WorldSettings worldSettings(const Trial& trial, double voxel) {
  WorldSettings settings;
  settings.common.method = trial.method;
  settings.common.threads = 1;  // trials already run side by side
  settings.voxel = voxel;
  settings.iterations = trial.iterations;
  settings.store = trial.store;
  return settings;
}

SceneGeometry boxFor(const Trial& trial, const Vec3& size) {
  if (takesPrimitives(trial)) return SceneBox{size};
  return meshOf(Box{size / 2}, size.norm());
}

SceneGeometry ballFor(const Trial& trial, double radius) {
  if (takesPrimitives(trial)) return SceneSphere{radius};
  return meshOf(Sphere{radius}, radius);
}

SceneGeometry cylinderFor(const Trial& trial, double radius, double length) {
  if (takesPrimitives(trial)) return SceneCylinder{radius, length};
  return meshOf(Cylinder{radius, length / 2}, radius);
}

SceneGeometry meshNamed(const std::string& name, std::shared_ptr<const Mesh> mesh) {
  return SceneMesh{name, Vec3::Ones(), std::move(mesh)};
}

}  // namespace cloudcontact::program::lab
