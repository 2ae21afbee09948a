// Turns a scene's bodies into Bullet's: shapes for the chosen method, masses, principal frames, and
// solids that measure penetration.
#pragma once

#include <cloudcontact/bullet/cuttable_body.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/options.h"
#include "scene/bullet_methods.h"
#include "scene/drawn_body.h"
#include "scene/penetration.h"
#include "scene/scene.h"
#include "scene/scene_clouds.h"

namespace cloudcontact::program {

// What a body that can be cut is made of.
struct CuttableMatter {
  Cloud cloud;
  Pose place;  // of the cloud's frame in the scene body's frame
  CuttableBodySettings settings;
  TissueTable tissues;
  std::optional<PaperSettings> paper;
};

// What a body that deforms is made of.
struct SoftMatter {
  Cloud cloud;
  Pose place;  // of the cloud's frame in the scene body's frame
  TissueTable tissues;
};

// A collision that cuts, in the Bullet body's frame.
struct SceneTool {
  Detection detection;
  Cutter cutter;
};

// The parts of a Bullet body. Its frame differs from the scene body's: Bullet needs the origin at
// the center of mass and a diagonal inertia.
struct BodyParts {
  BulletShape shape;
  Pose frame;                   // of the Bullet body in the scene body's frame
  double mass = 0;              // [kg], 0 for a static body
  Vec3 inertia = Vec3::Zero();  // about the frame's axes [kg m^2]
  MeasuredBody measured;        // in the scene body's frame
  bool isMeasured = true;       // false where a part has no mesh, or can be cut
  DrawnBody drawn;              // in the scene body's frame
  // For a body that can be cut, in place of shape, frame, mass and inertia.
  std::optional<CuttableMatter> matter;
  std::optional<SoftMatter> soft = {};  // likewise for a body that deforms
  std::vector<SceneTool> tools = {};
};

// Makes the parts. Equal bodies share meshes, clouds, fields and distance trees.
class SceneShapes {
 public:
  // `voxel` is the edge of the clouds' voxels [m]; every method takes its masses from clouds.
  // `store`, if any, shares slow results with other worlds.
  SceneShapes(const CommonOptions& options, double voxel,
              std::shared_ptr<ShapeStore> store = nullptr, const SceneTraits& traits = {});

  // Throws BadInput naming the body if its file is unusable, or if the method needs a primitive or
  // cannot use what the body is made of.
  BodyParts make(const SceneBody& body);

  // After all bodies: SceneClouds::checkTissues().
  void checkTissues() const { clouds_.checkTissues(); }

 private:
  struct Inertia;
  struct PlacedShape {
    BulletShape shape;
    Pose place;
  };
  bool hasDensity(const SceneBody& body);
  Inertia geometryInertia(const SceneBody& body);
  Inertia bodyInertia(const SceneBody& body);
  bool isOneShape(const SceneBody& body);
  bool meetsAsTriangles(const SceneCollision& collision, const SceneBody& body);
  BodyParts cuttable(const SceneBody& body);
  BodyParts soft(const SceneBody& body);
  void addPart(const SceneCollision& collision, const SceneBody& body, BodyParts& out,
               std::vector<PlacedShape>& shapes);
  PlacedShape partShape(const SceneCollision& collision, const Pose& pose, const SceneBody& body);
  Fidelity fidelityOf(const SceneCollision& collision) const {
    Fidelity fidelity;
    fidelity.tolerance = collision.tolerance.value_or(options_.tolerance);
    fidelity.exact = collision.tolerance ? *collision.tolerance == 0 : options_.exact;
    return fidelity;
  }
  PlacedField shownField(const SceneCollision& collision, const Pose& pose,
                         const std::string& body);
  BulletShape cloudShape(const SceneCollision& collision, const Pose& pose,
                         const std::string& body);
  std::optional<PaperSettings> paper(const SceneCollision& collision, double voxel,
                                     const Pose& pose, const std::string& body);
  std::optional<SceneTool> tool(const SceneCollision& collision, const Pose& pose,
                                const std::string& body);
  BulletShape bulletShape(const SceneGeometry& geometry, const Pose& pose, const std::string& body);
  void addVisual(const SceneCollision& visual, const SceneBody& body, BodyParts& out);
  DrawnPart drawnPart(const SceneCollision& collision, const SceneBody& of);
  std::shared_ptr<const Probed> probes(const SceneGeometry& geometry, const std::string& body);

  CommonOptions options_;
  SceneClouds clouds_;
  std::map<std::string, std::shared_ptr<const Mesh>> drawn_;
  std::map<std::string, BulletShape> bulletShapes_;
  std::map<std::string, std::shared_ptr<const Probed>> probed_;
};

}  // namespace cloudcontact::program
