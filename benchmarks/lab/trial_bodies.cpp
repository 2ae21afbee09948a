// Geometry, bodies and world settings of a trial.
#include "lab/trial_bodies.h"

#include <cloudcontact/law/automatic_spring.h>
#include <cloudcontact/law/solid.h>

#include <cmath>
#include <sstream>
#include <utility>

#include "demos/demo.h"
#include "scene/primitive_mesh.h"

namespace cloudcontact::program::lab {
namespace {

// Facet tolerance / body size, for peers that take meshes.
constexpr double kRound = 1e-3;

bool takesPrimitives(const Trial& trial) {
  return usesClouds(trial.method) || trial.method == Method::Primitive;
}

// Scenes identify meshes by name, so the name includes the size.
SceneGeometry meshOf(const Solid& shape, double size) {
  std::ostringstream name;
  name << "shape " << shape.index() << ' ' << boundsOf(shape).max().transpose();
  return meshNamed(name.str(), std::make_shared<const Mesh>(primitiveMesh(shape, kRound * size)));
}

}  // namespace

WorldSettings worldSettings(const Trial& trial, double voxel) {
  WorldSettings settings;
  settings.common.method = trial.method;
  settings.common.threads = 1;  // trials already run in parallel
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

SceneBody meshBody(const std::string& kind, std::shared_ptr<const Mesh> mesh, const Pose& pose,
                   double mass, double friction) {
  SceneBody body;
  body.pose = pose;
  body.isStatic = mass == 0;
  if (mass > 0) body.mass = mass;
  body.friction = friction;
  body.collisions.push_back({kind, Pose(), SceneMesh{kind, Vec3::Ones(), std::move(mesh)}});
  return body;
}

SceneBody boxBody(const Trial& trial, const Vec3& size, const Pose& pose, double mass,
                  double friction) {
  const std::string kind =
      "box " + figure(size.x(), 3) + " " + figure(size.y(), 3) + " " + figure(size.z(), 3);
  SceneBody body = meshBody(kind, {}, pose, mass, friction);
  body.collisions[0].geometry = boxFor(trial, size);
  return body;
}

SceneBody sphereBody(const Trial& trial, double radius, const Pose& pose, double mass,
                     double friction) {
  const std::string kind = "sphere " + figure(radius, 3);
  SceneBody body = meshBody(kind, {}, pose, mass, friction);
  body.collisions[0].geometry = ballFor(trial, radius);
  return body;
}

SceneBody floorBody(double friction) {
  SceneBody body;
  body.isStatic = true;
  body.friction = friction;
  body.collisions.push_back({"floor", Pose(), ScenePlane{}});
  return body;
}

Spring springFor(double mass, double load, double sag) {
  const double stiffness = load * kGravity / sag;
  return {stiffness, 2 * std::sqrt(stiffness * mass)};
}

Matter springMatter(double mass, double friction, double stiffness, double ratio) {
  return {mass, friction, stiffness, 2 * ratio * std::sqrt(stiffness * mass)};
}

bool isStiff(const Trial& trial) {
  return trial.mode == "stiff";
}

SceneBody& addBody(SceneDescription& scene, const std::string& name, const SceneGeometry& geometry,
                   const Vec3& position, const Matter& matter, const Trial& trial) {
  SceneBody body;
  body.name = name;
  body.model = int(scene.bodies.size());
  body.pose.position = position;
  body.isStatic = matter.mass == 0;
  if (matter.mass > 0) body.mass = matter.mass;
  body.friction = matter.friction;
  if (isStiff(trial) && matter.stiffness > 0) {
    body.stiffness = matter.stiffness;
    body.damping = matter.damping;
  }
  body.collisions.push_back({name, Pose(), geometry});
  scene.bodies.push_back(std::move(body));
  return scene.bodies.back();
}

SceneBody& addPlane(SceneDescription& scene, double friction) {
  return addBody(scene, "floor", ScenePlane{}, Vec3::Zero(), {0, friction}, {});
}

double sagOf(const Trial& trial, const Matter& matter, double force, double voxel) {
  if (isStiff(trial)) return force / matter.stiffness;
  if (!usesClouds(trial.method)) return 0;  // Bullet's rigid constraints
  return automaticSpring(matter.mass, matter.mass * kGravity, voxel, trial.step).sag(force);
}

}  // namespace cloudcontact::program::lab
