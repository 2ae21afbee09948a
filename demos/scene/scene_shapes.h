// From a scene's bodies to Bullet's: shapes by the method asked for, masses, principal frames, and
// the solids by which penetration is measured.
#pragma once

#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/voxels/cloud.h>

#include <map>
#include <string>

#include "io/options.h"
#include "scene/bullet_methods.h"
#include "scene/drawn_body.h"
#include "scene/penetration.h"
#include "scene/scene.h"
#include "scene/shape_store.h"

namespace cloudcontact::program {

// What a Bullet body is made of. Bullet wants the origin at the centre of mass and the inertia
// diagonal, so its frame is another one than the scene's.
struct BodyParts {
  BulletShape shape;
  Pose frame;                   // of the Bullet body in the scene body's frame
  double mass = 0;              // [kg], 0 for a static body
  Vec3 inertia = Vec3::Zero();  // about the frame's axes [kg m^2]
  MeasuredBody measured;        // in the scene body's frame
  DrawnBody drawn;              // in the scene body's frame
};

// Makes them, and keeps what equal bodies share: meshes, clouds, fields, distance trees.
class SceneShapes {
 public:
  // `voxel` is the clouds' [m]; masses come from clouds too, whatever the method.
  // `store`, where there is one, keeps what takes long for other worlds too.
  SceneShapes(const CommonOptions& options, double voxel,
              std::shared_ptr<ShapeStore> store = nullptr);

  // Throws BadInput naming the body: a mesh that cannot be used, a primitive asked of a mesh.
  BodyParts make(const SceneBody& body);

 private:
  struct Inertia;
  std::shared_ptr<const Mesh> mesh(const SceneGeometry& geometry, const std::string& body);
  Inertia geometryInertia(const SceneBody& body);
  Inertia bodyInertia(const SceneBody& body);
  Cloud cloud(const SceneGeometry& geometry, const Pose& pose, const std::string& body);
  BulletShape partShape(const SceneGeometry& geometry, const Pose& pose, const std::string& body);
  std::shared_ptr<const SurfaceField> field(const SceneGeometry& geometry, const Pose& pose,
                                            const std::string& body);
  DrawnPart drawnPart(const SceneCollision& collision, const std::string& body);

  CommonOptions options_;
  double voxel_;
  std::shared_ptr<ShapeStore> store_;
  std::map<std::string, std::shared_ptr<const Mesh>> meshes_, drawn_;
  std::map<std::string, Cloud> clouds_;
  std::map<std::string, std::shared_ptr<const SurfaceField>> fields_;
  std::map<std::string, BulletShape> bulletShapes_;
  std::map<std::string, std::shared_ptr<const Probed>> probed_;
};

// Voxels for a scene that names none: a hundredth of the smallest moving body's diagonal [m].
double defaultVoxel(const SceneDescription& scene, const CommonOptions& options);

}  // namespace cloudcontact::program
