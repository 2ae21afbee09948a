// The geometries of a scene as meshes, clouds and surface fields, each made once.
#pragma once

#include <cloudcontact/field/field_levels.h>
#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/law/tissue.h>
#include <cloudcontact/voxels/cloud.h>

#include <map>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "io/errors.h"
#include "io/options.h"
#include "scene/body.h"
#include "scene/scene.h"
#include "scene/shape_store.h"
#include "scene/tissue_file.h"

namespace cloudcontact::program {

// A cloud, or its field, and the place of its frame. A mesh is digitized in the axes of the body
// that it belongs to, at the identity. Other digital objects keep their own frame.
struct PlacedCloud {
  Cloud cloud;
  Pose place;
};
struct PlacedField {
  std::shared_ptr<const SurfaceField> field;
  Pose place;
};
struct PlacedLevels {
  std::shared_ptr<const FieldLevels> levels;
  Pose place;
};

// What the shapes of all bodies depend on.
struct SceneTraits {
  bool deforms = false;    // a body
  bool compounds = false;  // there are bodies of several collisions
  bool voxels = false;     // there are collisions whose voxels count: needsVoxels()
  // The geometries of bodies that move, each once, with a body that has it.
  std::vector<std::pair<SceneGeometry, std::string>> moving = {};
};
SceneTraits traitsOf(const SceneDescription& scene);

// Functions throw BadInput naming `body` or the file, if that is unusable.
class SceneClouds {
 public:
  // `voxel` [m] is the edge of voxels, but saved voxels keep their own, and without --voxel a
  // digital object gets voxels that keep its detail. `store` shares slow results with other worlds.
  SceneClouds(const CommonOptions& options, double voxel, std::shared_ptr<ShapeStore> store,
              const SceneTraits& traits);

  // Whether clouds meet the collision as the exact shape that it was given as, so that contacts
  // need no voxels of it: a plane, or a static body's primitive, or its mesh if that is a sheet or
  // far larger than what moves, and no thickness is stated (--shell). But voxels alone cut, are
  // cut, are of a tissue, have base vectors or meet bodies that deform, and a tolerance of 0 asks
  // for them.
  bool meetsAsShape(const SceneCollision& collision, const SceneBody& body);
  // A mesh as it is, mended.
  std::shared_ptr<const Mesh> triangles(const SceneGeometry& geometry, const std::string& body);

  // A mesh without an inside.
  bool isOpenMesh(const SceneGeometry& geometry, const std::string& body);
  // Points, voxels, a volume or another digital object: there is no mesh.
  bool isDigital(const SceneGeometry& geometry, const std::string& body);
  // Not for a plane or a digital object. A sheet becomes a shell.
  std::shared_ptr<const Mesh> mesh(const SceneGeometry& geometry, const std::string& body);
  // The surface of a digital object's cloud, for drawing.
  std::shared_ptr<const Mesh> drawn(const SceneGeometry& geometry, const std::string& body);
  // At `pose` in the body. Several parts of a mesh file become materials of their names.
  PlacedCloud cloud(const SceneGeometry& geometry, const Pose& pose, const std::string& body);
  PlacedField field(const SceneGeometry& geometry, const Pose& pose, const std::string& body);
  // Fields that contacts ask for, when they do.
  PlacedLevels levels(const SceneGeometry& geometry, const Pose& pose, const std::string& body);
  // The tissues of the collision's materials, from the table of --tissues: those that its elements
  // state, or else those of --tissue; empty where there are none.
  TissueTable tissues(const SceneCollision& collision, const std::string& body);
  void checkTissues() const;  // after all bodies: BodyTissues::check()
  // Of the collision's cloud at its place in the body: at the densities of its tissues, or at 1.
  MassProperties matter(const SceneCollision& collision, const std::string& body, bool atDensities);

  const std::shared_ptr<ShapeStore>& store() const { return store_; }
  const SceneTraits& traits() const { return traits_; }
  double voxel() const { return voxel_; }

 private:
  struct Mended {
    std::shared_ptr<const Mesh> mesh;
    bool isSheet = false;
  };
  const Body* file(const SceneGeometry& geometry, const std::string& body);
  const Mended& mendedMesh(const SceneGeometry& geometry, const std::string& body);
  // Whether it is much larger than all that moves, so that few of its voxels would ever touch.
  bool isLarge(const SceneGeometry& geometry, const std::string& body);
  // The diagonal [m].
  double sizeOf(const SceneGeometry& geometry, const std::string& body);
  // Of a geometry's voxels. A primitive meets most bodies as what it is. Clouds of other shapes
  // know it well enough by 128 voxels along it, or 12 across; a link of 0.3 m beside a peg of 0.1
  // mm voxels would have 14 million. A cloud that is made where something comes near would make
  // this needless.
  double voxelOf(const SceneGeometry& geometry) const;
  Cloud digitized(const SceneGeometry& geometry, const Pose& turn, const std::string& body);
  Cloud objectCloud(const SceneMesh& geometry, const std::string& body);
  std::vector<NamedMesh> parts(const SceneGeometry& geometry, const std::string& body);

  CommonOptions options_;
  double voxel_;
  std::shared_ptr<ShapeStore> store_;
  SceneTraits traits_;
  std::optional<double> largestMoving_;  // sizeOf()
  BodyTissues tissues_;                  // by --tissue
  std::optional<TissueTable> table_;     // of elements; read when first needed
  std::map<std::string, Body> files_;
  std::map<std::string, Mended> mended_;
  std::map<std::string, std::shared_ptr<const Mesh>> meshes_, drawn_;
  std::map<std::string, Cloud> clouds_;
  std::map<std::string, std::shared_ptr<const SurfaceField>> fields_;
  std::map<std::string, std::shared_ptr<const FieldLevels>> levels_;
};

// Turns the library's exceptions into BadInput that names the body.
template <class Work>
auto naming(const std::string& body, Work work) {
  try {
    return work();
  } catch (const BadInput&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw BadInput("body '" + body + "': needs more memory than there is; give a larger --voxel");
  } catch (const std::exception& error) {
    throw BadInput("body '" + body + "': " + error.what());
  }
}

bool isMesh(const SceneGeometry& geometry);
bool isPlane(const SceneGeometry& geometry);
// Not for a mesh.
Solid analytic(const SceneGeometry& geometry);
Mesh moved(const Mesh& mesh, const Pose& pose);

// Equal keys mean geometries, or poses, that are equal to the bit.
std::string keyOf(const SceneGeometry& geometry);
std::string keyOf(const Pose& pose);

// Default voxel size of a scene [m]: the least that a moving body gets (defaultVoxel(Body)).
double defaultVoxel(const SceneDescription& scene, const CommonOptions& options);

}  // namespace cloudcontact::program
