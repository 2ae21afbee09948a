// Turns a scene's bodies into Bullet's: shapes for the chosen method, masses, principal frames, and
// solids that measure penetration.
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
#include "scene/tissue_file.h"

namespace cloudcontact::program {

// The parts of a Bullet body. Its frame differs from the scene body's: Bullet needs the origin at
// the center of mass and a diagonal inertia.
struct BodyParts {
  BulletShape shape;
  Pose frame;                   // of the Bullet body in the scene body's frame
  double mass = 0;              // [kg], 0 for a static body
  Vec3 inertia = Vec3::Zero();  // about the frame's axes [kg m^2]
  MeasuredBody measured;        // in the scene body's frame
  DrawnBody drawn;              // in the scene body's frame
};

// Makes the parts. Equal bodies share meshes, clouds, fields and distance trees.
class SceneShapes {
 public:
  // `voxel` is the edge of the clouds' voxels [m]; every method takes its masses from clouds.
  // `store`, if any, shares slow results with other worlds.
  SceneShapes(const CommonOptions& options, double voxel,
              std::shared_ptr<ShapeStore> store = nullptr);

  // Throws BadInput naming the body if its mesh is unusable, or if the method needs a primitive.
  BodyParts make(const SceneBody& body);

  // After all bodies: BodyTissues::check().
  void checkTissues() const { tissues_.check(); }

 private:
  struct Inertia;
  std::shared_ptr<const Mesh> mesh(const SceneGeometry& geometry, const std::string& body);
  Inertia geometryInertia(const SceneBody& body);
  Inertia bodyInertia(const SceneBody& body);
  Cloud cloud(const SceneGeometry& geometry, const Pose& pose, const std::string& body);
  std::string settingsKey() const;  // of what clouds depend on beside their meshes
  Cloud digitized(const SceneGeometry& geometry, const Mesh& turned, const Eigen::Quaterniond& turn,
                  const std::string& body);
  BulletShape cloudShape(const SceneGeometry& geometry, const Pose& pose, const std::string& body);
  BulletShape partShape(const SceneGeometry& geometry, const Pose& pose, const std::string& body);
  std::shared_ptr<const SurfaceField> field(const SceneGeometry& geometry, const Pose& pose,
                                            const std::string& body);
  DrawnPart drawnPart(const SceneCollision& collision, const std::string& body);

  CommonOptions options_;
  double voxel_;
  BodyTissues tissues_;
  std::shared_ptr<ShapeStore> store_;
  std::map<std::string, std::shared_ptr<const Mesh>> meshes_, drawn_;
  std::map<std::string, Cloud> clouds_;
  std::map<std::string, std::shared_ptr<const SurfaceField>> fields_;
  std::map<std::string, BulletShape> bulletShapes_;
  std::map<std::string, std::shared_ptr<const Probed>> probed_;
};

// Default voxel size of a scene: a hundredth of the smallest moving body's diagonal [m].
double defaultVoxel(const SceneDescription& scene, const CommonOptions& options);

}  // namespace cloudcontact::program
