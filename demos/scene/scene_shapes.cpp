// Makes shapes, once for each different geometry.
#include "scene/scene_shapes.h"

#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/voxels/matter_sums.h>
#include <cloudcontact/workpiece/cloud_solid.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <sstream>

#include "io/errors.h"
#include "scene/bullet_vectors.h"
#include "scene/paper_settings.h"
#include "scene/primitive_mesh.h"

namespace cloudcontact::program {
namespace {

constexpr double kDefaultDensity = 1000;  // of bodies without a mass: water [kg/m^3]
constexpr double kCrumb = 20;             // smaller pieces count as cut away [voxels]
constexpr double kDrawnTolerance = 5e-4;  // of a primitive's diagonal: invisible at 1000 px

bool isIdentity(const Pose& pose) {
  return pose.position.isZero() && pose.orientation.coeffs().head<3>().isZero();
}

// Equal keys mean equal elements of our own.
std::string keyOfElements(const SceneCollision& collision) {
  std::ostringstream key;
  key << std::hexfloat;
  for (const SceneTissue& tissue : collision.tissues)
    key << " t " << tissue.part.size() << ' ' << tissue.part << ' ' << tissue.name;
  for (const auto* solid : {&collision.paper.window, &collision.paper.area})
    if (*solid) key << " s " << (*solid)->index() << boundsOf(**solid).sizes().transpose();
  if (collision.paper.representative) key << " g " << collision.paper.representative->transpose();
  if (collision.cutter) key << " c " << collision.cutter->ability;
  if (collision.tolerance) key << " e " << *collision.tolerance;
  return key.str();
}

// Voxels alone can be of a tissue, cut or be cut, have base vectors, or be without a mesh.
void refuseMethod(Method method, const std::string& body, const std::string& why) {
  throw BadInput("--method " + std::string(nameOf(method)) + ": body '" + body + "' " + why +
                 "; use cloud");
}

}  // namespace

// Mass, center and inertia in the scene body's frame.
struct SceneShapes::Inertia {
  double mass = 0;  // or the volume
  Vec3 center = Vec3::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // about the center
};

SceneShapes::SceneShapes(const CommonOptions& options, double voxel,
                         std::shared_ptr<ShapeStore> store, const SceneTraits& traits)
    : options_(options), clouds_(options, voxel, std::move(store), traits) {}

// Whether a body's tissues give it a density.
bool SceneShapes::hasDensity(const SceneBody& body) {
  for (const auto& collision : body.collisions)
    if (isPlane(collision.geometry) || clouds_.tissues(collision, body.name).empty()) return false;
  return !body.collisions.empty();
}

// At the densities of tissues where all collisions have them, else at 1.
SceneShapes::Inertia SceneShapes::geometryInertia(const SceneBody& body) {
  std::vector<MassProperties> parts;
  const bool weighs = hasDensity(body);
  for (const auto& collision : body.collisions)
    if (!isPlane(collision.geometry)) parts.push_back(clouds_.matter(collision, body.name, weighs));
  const MassProperties sum = sumOf(parts);
  if (!(sum.mass > 0))
    throw BadInput("body '" + body.name +
                   "': moves but has no <collision> to take its inertia from; add one, or make it "
                   "<static>");
  return {sum.mass, sum.centerOfMass, sum.inertia};
}

SceneShapes::Inertia SceneShapes::bodyInertia(const SceneBody& body) {
  Inertia result;
  if (body.mass && body.inertia) {
    const Pose at = body.inertialPose.value_or(Pose());
    const Eigen::Matrix3d r = at.orientation.toRotationMatrix();
    return {*body.mass, at.position, r * *body.inertia * r.transpose()};
  }
  result = geometryInertia(body);
  const double density = body.mass          ? *body.mass / result.mass
                         : hasDensity(body) ? 1
                                            : kDefaultDensity;
  result.mass *= density;
  result.inertia *= density;
  if (body.inertialPose) result.center = body.inertialPose->position;
  return result;
}

// Meshes as they are; primitives coarser than for contacts.
DrawnPart SceneShapes::drawnPart(const SceneCollision& collision, const SceneBody& of) {
  const std::string& body = of.name;
  DrawnPart part;
  part.pose = collision.pose;
  if (isPlane(collision.geometry)) {
    part.planeNormal = std::get<ScenePlane>(collision.geometry).normal;
  } else if (clouds_.isDigital(collision.geometry, body)) {
    part.mesh = clouds_.drawn(collision.geometry, body);
  } else if (meetsAsTriangles(collision, of)) {
    part.mesh = clouds_.triangles(collision.geometry, body);
  } else if (isMesh(collision.geometry)) {
    part.mesh = clouds_.mesh(collision.geometry, body);
  } else {
    auto& kept = drawn_[keyOf(collision.geometry)];
    if (!kept) {
      const Solid shape = analytic(collision.geometry);
      const double size = boundsOf(shape).diagonal().norm();
      kept = std::make_shared<const Mesh>(primitiveMesh(shape, kDrawnTolerance * size));
    }
    part.mesh = kept;
  }
  return part;
}

// The shape of one collision at `pose` in the Bullet body's frame. What is digitized from a mesh is
// moved there itself; digital objects, and shapes that clouds meet as they are, have a place.
SceneShapes::PlacedShape SceneShapes::partShape(const SceneCollision& collision, const Pose& pose,
                                                const SceneBody& body) {
  const SceneGeometry& geometry = collision.geometry;
  if (isPlane(geometry)) {
    const Vec3 normal = pose.orientation * std::get<ScenePlane>(geometry).normal;
    return {primitiveShape(HalfSpace{normal, normal.dot(pose.position)}), Pose()};
  }
  const std::string& name = body.name;
  if (usesClouds(options_.method)) {
    if (clouds_.meetsAsShape(collision, body)) return {bulletShape(geometry, Pose(), name), pose};
    return {cloudShape(collision, pose, name), clouds_.isDigital(geometry, name) ? pose : Pose()};
  }
  if (clouds_.isDigital(geometry, name)) refuseMethod(options_.method, name, "has no mesh");
  if (!collision.tissues.empty()) refuseMethod(options_.method, name, "has tissues");
  if (collision.paper.isGiven()) refuseMethod(options_.method, name, "has base vectors");
  if (collision.cutter) refuseMethod(options_.method, name, "cuts");
  return {bulletShape(geometry, pose, name), Pose()};
}

// The field that most contacts of a collision use. Base vectors use the finest.
PlacedField SceneShapes::shownField(const SceneCollision& collision, const Pose& pose,
                                    const std::string& body) {
  const double tolerance = fidelityOf(collision).tolerance;
  if (!(tolerance > 0)) return clouds_.field(collision.geometry, pose, body);
  return naming(body, [&]() -> PlacedField {
    const auto [levels, place] = clouds_.levels(collision.geometry, pose, body);
    return {levels->field(levels->coarsest(tolerance / 2)), place};
  });
}

// Equal bodies share base vectors.
BulletShape SceneShapes::cloudShape(const SceneCollision& collision, const Pose& pose,
                                    const std::string& body) {
  auto& kept =
      bulletShapes_["cloud " + keyOf(collision.geometry) + keyOf(pose) + keyOfElements(collision)];
  if (kept.shape) return kept;
  return kept = naming(body, [&]() -> BulletShape {
           const Fidelity fidelity = fidelityOf(collision);
           auto shape = fidelity.tolerance > 0
                            ? std::make_shared<CloudShape>(
                                  clouds_.levels(collision.geometry, pose, body).levels)
                            : std::make_shared<CloudShape>(
                                  clouds_.field(collision.geometry, pose, body).field);
           shape->setTissues(clouds_.tissues(collision, body));
           if (!isMesh(collision.geometry))
             shape->setSolid({analytic(collision.geometry), pose}, clouds_.voxel());
           shape->setFidelity(fidelity);
           const double voxel = shape->voxelSize();
           // Bullet asks for the contacts of a compound's children only where their boxes meet, but
           // near misses reach a voxel.
           if (clouds_.traits().compounds) shape->setMargin(btScalar(voxel));
           if (const auto settings = paper(collision, voxel, pose, body))
             shape->usePaper(*settings);
           return {{}, shape};
         });
}

// C, Gr and D of elements, then of the command line; with the collision at `pose` in the axes in
// which a mesh is digitized.
std::optional<PaperSettings> SceneShapes::paper(const SceneCollision& collision, double voxel,
                                                const Pose& pose, const std::string& body) {
  if (options_.method != Method::Paper && !collision.paper.isGiven()) return {};
  const Pose place = clouds_.isDigital(collision.geometry, body) ? Pose() : pose;
  PaperOptions options = options_.paper;
  if (collision.paper.window) options.window = collision.paper.window;
  if (collision.paper.representative) options.representative = collision.paper.representative;
  options.hardness = options.hardness || !collision.tissues.empty();
  PaperSettings settings = paperSettings(options, voxel, place.orientation);
  if (collision.paper.area) settings.area = PlacedSolid{*collision.paper.area, place};
  if (collision.cutter) settings.ability = collision.cutter->ability;
  return settings;
}

// What cuts is <area>, or else the collision's own shape.
std::optional<SceneTool> SceneShapes::tool(const SceneCollision& collision, const Pose& pose,
                                           const std::string& body) {
  if (!collision.cutter) return {};
  return naming(body, [&] {
    SceneTool tool;
    tool.cutter = collision.cutter->cutter;
    tool.detection.ability = collision.cutter->ability;
    if (collision.paper.area) {
      tool.detection.area = {*collision.paper.area, pose};
    } else if (!isMesh(collision.geometry)) {
      tool.detection.area = {analytic(collision.geometry), pose};
    } else {
      const auto [cloud, place] = clouds_.cloud(collision.geometry, pose, body);
      tool.detection.area = cloudSolid(cloud, place);
    }
    return tool;
  });
}

BulletShape SceneShapes::bulletShape(const SceneGeometry& geometry, const Pose& pose,
                                     const std::string& body) {
  auto& kept = bulletShapes_[keyOf(geometry) + keyOf(pose)];
  if (kept.shape) return kept;
  return kept = naming(body, [&]() -> BulletShape {
           if (!isMesh(geometry)) {
             BulletShape bare = primitiveShape(analytic(geometry));
             if (isIdentity(pose)) return bare;
             auto compound = std::make_shared<btCompoundShape>(false, 1);
             compound->addChildShape(toBullet(pose), bare.shape.get());
             bare.keep.push_back(bare.shape);
             return {bare.keep, compound};
           }
           if (usesClouds(options_.method)) {
             std::cerr << "cloudcontact: body '" << body << "' "
                       << (clouds_.isOpenMesh(geometry, body)
                               ? "has no inside and stands still: bodies meet its triangles "
                                 "(--shell makes it a shell)\n"
                               : "is large and stands still: bodies meet its triangles "
                                 "(<cloudcontact:tolerance>0 makes voxels)\n");
             return trianglesShape(*clouds_.triangles(geometry, body));
           }
           const Mesh at = moved(*clouds_.mesh(geometry, body), pose);
           if (options_.method == Method::Gjk) return hullShape(at);
           if (options_.method == Method::Gimpact) return gimpactShape(at);
           if (options_.method == Method::Hacd)
             return convexPartsShape(
                 clouds_.store()->parts.get(contentKey(at), [&] { return convexParts(at); }));
           throw BadInput("--method " + std::string(nameOf(options_.method)) + ": body '" + body +
                          "' is a mesh; use cloud, gjk, gimpact or hacd");
         });
}

std::shared_ptr<const Probed> SceneShapes::probes(const SceneGeometry& geometry,
                                                  const std::string& body) {
  auto& kept = probed_[keyOf(geometry)];
  if (!kept)
    kept = probed(geometry, isPlane(geometry) ? nullptr : clouds_.mesh(geometry, body).get());
  return kept;
}

void SceneShapes::addPart(const SceneCollision& collision, const SceneBody& body, BodyParts& out,
                          std::vector<PlacedShape>& shapes) {
  const Pose placed = out.frame.inverse() * collision.pose;
  shapes.push_back(partShape(collision, placed, body));
  out.drawn.parts.push_back(drawnPart(collision, body));
  if (const auto cuts = tool(collision, placed, body.name)) out.tools.push_back(*cuts);
  if (usesClouds(options_.method) && !clouds_.meetsAsShape(collision, body)) {
    const auto [field, place] = shownField(collision, placed, body.name);
    out.drawn.clouds.push_back({field, out.frame * place});
  }
  if (clouds_.isDigital(collision.geometry, body.name) ||
      (meetsAsTriangles(collision, body) && clouds_.isOpenMesh(collision.geometry, body.name)))
    out.isMeasured = false;  // without an inside there is no depth
  else
    out.measured.parts.push_back({probes(collision.geometry, body.name), collision.pose});
}

// Its mass and frame follow from its matter.
BodyParts SceneShapes::cuttable(const SceneBody& body) {
  const SceneCollision& collision = body.collisions.front();
  if (!usesClouds(options_.method)) refuseMethod(options_.method, body.name, "can be cut");
  BodyParts out;
  out.isMeasured = false;
  const auto [cloud, place] = clouds_.cloud(collision.geometry, collision.pose, body.name);
  CuttableMatter& matter = out.matter.emplace();
  matter.cloud = cloud;
  matter.place = place;
  matter.tissues = clouds_.tissues(collision, body.name);
  if (matter.tissues.empty())
    throw BadInput(collision.where +
                   " <cloudcontact:cuttable>: its tissue is missing, whose hardness resists the "
                   "cutter; add a <cloudcontact:tissue>");
  matter.paper = paper(collision, cloud.voxelSize(), collision.pose, body.name);
  std::vector<double>& densities = matter.settings.densities;
  densities.clear();
  for (const Tissue& tissue : matter.tissues) densities.push_back(tissue.density);
  if (body.mass) {
    const double mass = massPropertiesOf(matterSums(cloud), cloud, densities).mass;
    for (double& density : densities) density *= *body.mass / mass;
  }
  matter.settings.leastPiece = kCrumb * std::pow(cloud.voxelSize(), 3) *
                               *std::min_element(densities.begin(), densities.end());
  matter.settings.threads = options_.threads;
  return out;
}

BodyParts SceneShapes::soft(const SceneBody& body) {
  const SceneCollision& collision = body.collisions.front();
  if (!usesClouds(options_.method)) refuseMethod(options_.method, body.name, "deforms");
  BodyParts out;
  out.isMeasured = false;
  const auto [cloud, place] = clouds_.cloud(collision.geometry, collision.pose, body.name);
  TissueTable tissues = clouds_.tissues(collision, body.name);
  if (body.mass) {
    std::vector<double> densities;
    for (const Tissue& tissue : tissues) densities.push_back(tissue.density);
    const double mass = massPropertiesOf(matterSums(cloud), cloud, densities).mass;
    for (Tissue& tissue : tissues) tissue.density *= *body.mass / mass;
  }
  out.soft = SoftMatter{cloud, place, std::move(tissues)};
  return out;
}

bool SceneShapes::meetsAsTriangles(const SceneCollision& collision, const SceneBody& body) {
  return usesClouds(options_.method) && isMesh(collision.geometry) &&
         clouds_.meetsAsShape(collision, body);
}

// A mesh as it is, with or without an inside. One that cannot be read is not drawn.
void SceneShapes::addVisual(const SceneCollision& visual, const SceneBody& body, BodyParts& out) {
  try {
    if (isMesh(visual.geometry) && !clouds_.isDigital(visual.geometry, body.name))
      out.drawn.parts.push_back({clouds_.triangles(visual.geometry, body.name), visual.pose, {}});
    else
      out.drawn.parts.push_back(drawnPart(visual, body));
  } catch (const BadInput& why) {
    std::cerr << "cloudcontact: " << why.what() << " (it is not drawn)\n";
  }
}

// A shape that clouds meet as it is: in its own frame it needs no compound, whose children
// Bullet asks for contacts only once their boxes meet.
bool SceneShapes::isOneShape(const SceneBody& body) {
  return usesClouds(options_.method) && body.collisions.size() == 1 &&
         !isPlane(body.collisions[0].geometry) && clouds_.meetsAsShape(body.collisions[0], body);
}

BodyParts SceneShapes::make(const SceneBody& body) {
  if (body.isSoft()) return naming(body.name, [&] { return soft(body); });
  if (body.collisions.size() == 1 && body.collisions[0].isCuttable)
    return naming(body.name, [&] { return cuttable(body); });
  BodyParts out;
  if (body.isFree()) {
    const Inertia inertia = bodyInertia(body);
    out.mass = inertia.mass;
    out.frame = {
        principalAxes(inertia.inertia, Eigen::Quaterniond::Identity(), kDiagonalEnough).orientation,
        inertia.center};
    const Eigen::Matrix3d r = out.frame.orientation.toRotationMatrix();
    out.inertia = (r.transpose() * inertia.inertia * r).diagonal();
  } else if (isOneShape(body)) {
    out.frame = body.collisions[0].pose;
  }
  std::vector<PlacedShape> shapes;
  for (const auto& collision : body.collisions) addPart(collision, body, out, shapes);
  for (const auto& visual : body.visuals) addVisual(visual, body, out);
  if (shapes.size() == 1 && isIdentity(shapes.front().place)) {
    out.shape = shapes.front().shape;
    return out;
  }
  auto compound = std::make_shared<btCompoundShape>();  // empty where there is no collision
  for (auto& [part, place] : shapes) {
    compound->addChildShape(toBullet(place), part.shape.get());
    out.shape.keep.insert(out.shape.keep.end(), part.keep.begin(), part.keep.end());
    out.shape.keep.push_back(part.shape);
  }
  out.shape.shape = compound;
  return out;
}

}  // namespace cloudcontact::program
