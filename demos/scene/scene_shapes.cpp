// Makes shapes, once for each different geometry.
#include "scene/scene_shapes.h"

#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/mesh/mesh_file.h>
#include <cloudcontact/mesh/mesh_repair.h>
#include <cloudcontact/voxels/digitize.h>

#include <Eigen/Eigenvalues>
#include <iostream>
#include <sstream>

#include "io/errors.h"
#include "io/progress.h"
#include "scene/body.h"
#include "scene/bullet_vectors.h"
#include "scene/paper_settings.h"
#include "scene/primitive_mesh.h"

namespace cloudcontact::program {
namespace {

constexpr double kFacetTolerance = 0.002;  // of primitives' meshes [voxels]
constexpr double kDefaultDensity = 1000;   // of bodies without a mass: water [kg/m^3]
constexpr double kDiagonalEnough = 1e-3;   // off-diagonals below this share count as 0
constexpr double kVoxelOfDiagonal = 0.01;
constexpr double kDrawnTolerance = 5e-4;  // of a primitive's diagonal: invisible at 1000 px

bool isMesh(const SceneGeometry& g) {
  return std::holds_alternative<SceneMesh>(g);
}
bool isPlane(const SceneGeometry& g) {
  return std::holds_alternative<ScenePlane>(g);
}

Solid analytic(const SceneGeometry& geometry) {
  struct Visitor {
    Solid operator()(const SceneBox& b) const { return Box{b.size / 2}; }
    Solid operator()(const SceneSphere& s) const { return Sphere{s.radius}; }
    Solid operator()(const SceneCylinder& c) const { return Cylinder{c.radius, c.length / 2}; }
    Solid operator()(const SceneCapsule& c) const { return Capsule{c.radius, c.length / 2}; }
    Solid operator()(const ScenePlane& p) const { return HalfSpace{p.normal, 0}; }
    Solid operator()(const SceneMesh&) const { return Hull{}; }
  };
  return std::visit(Visitor{}, geometry);
}

// Equal keys mean geometry that is equal to the bit.
std::string keyOf(const SceneGeometry& geometry) {
  std::ostringstream key;
  key << std::hexfloat << geometry.index();
  struct Visitor {
    std::ostream& out;
    void operator()(const SceneBox& b) const { out << ' ' << b.size.transpose(); }
    void operator()(const SceneSphere& s) const { out << ' ' << s.radius; }
    void operator()(const SceneCylinder& c) const { out << ' ' << c.radius << ' ' << c.length; }
    void operator()(const SceneCapsule& c) const { out << ' ' << c.radius << ' ' << c.length; }
    void operator()(const ScenePlane& p) const { out << ' ' << p.normal.transpose(); }
    void operator()(const SceneMesh& m) const {
      out << ' ' << m.file.string() << ' ' << m.scale.transpose();
    }
  };
  std::visit(Visitor{key}, geometry);
  return key.str();
}

std::string keyOf(const Eigen::Quaterniond& q) {
  std::ostringstream key;
  key << std::hexfloat << " q " << q.coeffs().transpose();
  return key.str();
}

std::string keyOf(const Vec3& v) {
  std::ostringstream key;
  key << std::hexfloat << " p " << v.transpose();
  return key.str();
}

Mesh moved(const Mesh& mesh, const Pose& pose) {
  Mesh out = mesh;
  for (Vec3& v : out.vertices) v = pose.toWorld(v);
  return out;
}

// Turns the library's exceptions into BadInput that names the body.
template <class Work>
auto naming(const std::string& body, Work work) {
  try {
    return work();
  } catch (const BadInput&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw BadInput("body '" + body + "': " + error.what());
  }
}

// Axes in which the inertia is diagonal, each as close to the given one as possible.
Eigen::Quaterniond principalAxes(const Eigen::Matrix3d& inertia) {
  const double most = inertia.diagonal().cwiseAbs().maxCoeff();
  const Eigen::Matrix3d off = inertia - Eigen::Matrix3d(inertia.diagonal().asDiagonal());
  if (off.cwiseAbs().maxCoeff() <= kDiagonalEnough * most) return Eigen::Quaterniond::Identity();
  const Eigen::Matrix3d vectors =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia).eigenvectors();
  Eigen::Matrix3d axes;
  bool used[3] = {};
  for (int axis = 0; axis < 3; ++axis) {
    int best = -1;
    for (int k = 0; k < 3; ++k)
      if (!used[k] && (best < 0 || std::abs(vectors(axis, k)) > std::abs(vectors(axis, best))))
        best = k;
    used[best] = true;
    axes.col(axis) = vectors.col(best) * (vectors(axis, best) < 0 ? -1.0 : 1.0);
  }
  if (axes.determinant() < 0) axes.col(2) = -axes.col(2);
  return Eigen::Quaterniond(axes).normalized();
}

}  // namespace

// Mass, center and inertia in the scene body's frame.
struct SceneShapes::Inertia {
  double mass = 0;  // or the volume
  Vec3 center = Vec3::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // about the center
};

SceneShapes::SceneShapes(const CommonOptions& options, double voxel,
                         std::shared_ptr<ShapeStore> store)
    : options_(options),
      voxel_(voxel),
      tissues_(options.tissues),
      store_(store ? std::move(store) : std::make_shared<ShapeStore>()) {}

std::shared_ptr<const Mesh> SceneShapes::mesh(const SceneGeometry& geometry,
                                              const std::string& body) {
  auto& kept = meshes_[keyOf(geometry)];
  if (kept) return kept;
  return kept = naming(body, [&] {
           if (!isMesh(geometry))
             return std::make_shared<const Mesh>(
                 primitiveMesh(analytic(geometry), kFacetTolerance * voxel_));
           const auto& named = std::get<SceneMesh>(geometry);
           Mesh mesh = named.mesh ? *named.mesh : loadMesh(named.file, options_.metersPerUnit);
           mesh = mended(mesh.scaled(named.scale));
           if (isSheet(mesh)) {
             const double thickness = options_.shell.value_or(3 * voxel_);
             std::cerr << "cloudcontact: " << named.file.string() << " has no inside; made a shell "
                       << thickness << " m thick behind its faces (--shell)\n";
             mesh = shell(mesh, thickness);
           }
           return std::make_shared<const Mesh>(std::move(mesh));
         });
}

std::string SceneShapes::settingsKey() const {
  return keyOf(Vec3(voxel_, 0, 0)) + (options_.tissues.given() ? " parts" : "");
}

// The mesh, or the parts of its file as materials if tissues are given.
Cloud SceneShapes::digitized(const SceneGeometry& geometry, const Mesh& turned,
                             const Eigen::Quaterniond& turn, const std::string& body) {
  DigitizeSettings settings;
  settings.voxelSize = voxel_;
  settings.threads = options_.threads;
  settings.progress = progressBar("digitizing " + body);
  const auto* const file = std::get_if<SceneMesh>(&geometry);
  if (!options_.tissues.given() || !file || file->mesh) return digitize(turned, settings);
  std::vector<NamedMesh> parts = loadMeshParts(file->file, options_.metersPerUnit);
  if (parts.size() < 2 || parts.size() > kMostParts || isSheet(merged(parts)))
    return digitize(turned, settings);
  for (NamedMesh& part : parts)
    part.mesh = moved(part.mesh.scaled(file->scale), {turn, Vec3::Zero()});
  return digitize(parts, settings);
}

// Digitizes once for each orientation; positions share the cloud.
Cloud SceneShapes::cloud(const SceneGeometry& geometry, const Pose& pose, const std::string& body) {
  Cloud& kept = clouds_[keyOf(geometry) + keyOf(pose.orientation)];
  if (kept.empty()) {
    const auto original = mesh(geometry, body);
    kept = naming(body, [&] {
      const Mesh turned = moved(*original, {pose.orientation, Vec3::Zero()});
      return store_->clouds.get(contentKey(turned) + settingsKey(), [&] {
        return digitized(geometry, turned, pose.orientation, body);
      });
    });
  }
  return kept.translated(pose.position);
}

SceneShapes::Inertia SceneShapes::geometryInertia(const SceneBody& body) {
  Inertia sum;
  std::vector<MassProperties> parts;
  for (const auto& collision : body.collisions) {
    if (isPlane(collision.geometry)) continue;
    parts.push_back(cloud(collision.geometry, collision.pose, body.name).massProperties());
    sum.mass += parts.back().volume;
    sum.center += parts.back().volume * parts.back().centerOfMass;
  }
  if (!(sum.mass > 0))
    throw BadInput("body '" + body.name +
                   "': moves but has no <collision> to take its inertia from; add one, or make it "
                   "<static>");
  sum.center /= sum.mass;
  for (const auto& part : parts) {
    const Vec3 r = part.centerOfMass - sum.center;
    sum.inertia += part.inertia + part.volume * (r.squaredNorm() * Eigen::Matrix3d::Identity() -
                                                 r * r.transpose());
  }
  return sum;
}

SceneShapes::Inertia SceneShapes::bodyInertia(const SceneBody& body) {
  Inertia result;
  if (body.mass && body.inertia) {
    const Pose at = body.inertialPose.value_or(Pose());
    const Eigen::Matrix3d r = at.orientation.toRotationMatrix();
    return {*body.mass, at.position, r * *body.inertia * r.transpose()};
  }
  result = geometryInertia(body);
  const double density = body.mass ? *body.mass / result.mass : kDefaultDensity;
  result.mass *= density;
  result.inertia *= density;
  if (body.inertialPose) result.center = body.inertialPose->position;
  return result;
}

std::shared_ptr<const SurfaceField> SceneShapes::field(const SceneGeometry& geometry,
                                                       const Pose& pose, const std::string& body) {
  auto& kept = fields_[keyOf(geometry) + keyOf(pose.orientation) + keyOf(pose.position)];
  if (kept) return kept;
  const std::string key = contentKey(*mesh(geometry, body)) + keyOf(pose.orientation) +
                          keyOf(pose.position) + settingsKey();
  return kept = store_->fields.get(
             key, [&] { return buildField(cloud(geometry, pose, body), body, options_); });
}

// Meshes as they are; primitives coarser than for contacts.
DrawnPart SceneShapes::drawnPart(const SceneCollision& collision, const std::string& body) {
  DrawnPart part;
  part.pose = collision.pose;
  if (isPlane(collision.geometry)) {
    part.planeNormal = std::get<ScenePlane>(collision.geometry).normal;
  } else if (isMesh(collision.geometry)) {
    part.mesh = mesh(collision.geometry, body);
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

BulletShape SceneShapes::cloudShape(const SceneGeometry& geometry, const Pose& pose,
                                    const std::string& body) {
  auto shape = std::make_shared<CloudShape>(field(geometry, pose, body));
  const Cloud& cloud = shape->field().cloud();
  shape->setTissues(tissues_.of(body, cloud.materials()));
  if (options_.method == Method::Paper)
    shape->usePaper(paperSettings(options_.paper, cloud.voxelSize(), pose.orientation));
  return {{}, shape};
}

// The shape of one collision in the Bullet body's frame: the mesh is moved, not the shape.
BulletShape SceneShapes::partShape(const SceneGeometry& geometry, const Pose& pose,
                                   const std::string& body) {
  if (isPlane(geometry)) {
    const Vec3 normal = pose.orientation * std::get<ScenePlane>(geometry).normal;
    return primitiveShape(HalfSpace{normal, normal.dot(pose.position)});
  }
  auto& kept = bulletShapes_[keyOf(geometry) + keyOf(pose.orientation) + keyOf(pose.position)];
  if (kept.shape) return kept;
  return kept = naming(body, [&]() -> BulletShape {
           if (usesClouds(options_.method)) return cloudShape(geometry, pose, body);
           if (!isMesh(geometry)) {
             BulletShape bare = primitiveShape(analytic(geometry));
             if (pose.position.isZero() && pose.orientation.coeffs().head<3>().isZero())
               return bare;
             auto compound = std::make_shared<btCompoundShape>(false, 1);
             compound->addChildShape(toBullet(pose), bare.shape.get());
             bare.keep.push_back(bare.shape);
             return {bare.keep, compound};
           }
           const Mesh at = moved(*mesh(geometry, body), pose);
           if (options_.method == Method::Gjk) return hullShape(at);
           if (options_.method == Method::Gimpact) return gimpactShape(at);
           if (options_.method == Method::Hacd)
             return convexPartsShape(
                 store_->parts.get(contentKey(at), [&] { return convexParts(at); }));
           throw BadInput("--method " + std::string(nameOf(options_.method)) + ": body '" + body +
                          "' is a mesh; use cloud, gjk, gimpact or hacd");
         });
}

BodyParts SceneShapes::make(const SceneBody& body) {
  BodyParts out;
  if (!body.isStatic) {
    const Inertia inertia = bodyInertia(body);
    out.mass = inertia.mass;
    out.frame = {principalAxes(inertia.inertia), inertia.center};
    const Eigen::Matrix3d r = out.frame.orientation.toRotationMatrix();
    out.inertia = (r.transpose() * inertia.inertia * r).diagonal();
  }
  std::vector<BulletShape> shapes;
  for (const auto& collision : body.collisions) {
    const auto& geometry = collision.geometry;
    const Pose placed = out.frame.inverse() * collision.pose;
    shapes.push_back(partShape(geometry, placed, body.name));
    out.drawn.parts.push_back(drawnPart(collision, body.name));
    if (usesClouds(options_.method) && !isPlane(geometry))
      out.drawn.clouds.push_back({field(geometry, placed, body.name), out.frame});
    auto& probes = probed_[keyOf(geometry)];
    if (!probes)
      probes = probed(geometry, isPlane(geometry) ? nullptr : mesh(geometry, body.name).get());
    out.measured.parts.push_back({probes, collision.pose});
  }
  if (shapes.size() == 1) {
    out.shape = shapes.front();
    return out;
  }
  auto compound = std::make_shared<btCompoundShape>();  // empty where there is no collision
  for (BulletShape& part : shapes) {
    compound->addChildShape(btTransform::getIdentity(), part.shape.get());
    out.shape.keep.insert(out.shape.keep.end(), part.keep.begin(), part.keep.end());
    out.shape.keep.push_back(part.shape);
  }
  out.shape.shape = compound;
  return out;
}

double defaultVoxel(const SceneDescription& scene, const CommonOptions& options) {
  // The voxel is not known yet; only sizes are needed here.
  double least = std::numeric_limits<double>::infinity();
  for (const auto& body : scene.bodies)
    for (const auto& collision : body.collisions) {
      if (body.isStatic || isPlane(collision.geometry)) continue;
      Eigen::AlignedBox3d box;
      if (isMesh(collision.geometry)) {
        const auto& named = std::get<SceneMesh>(collision.geometry);
        const Mesh mesh = naming(body.name, [&] {
          return named.mesh ? *named.mesh : loadMesh(named.file, options.metersPerUnit);
        });
        for (const Vec3& v : mesh.vertices) box.extend(v.cwiseProduct(named.scale));
      } else {
        box = boundsOf(analytic(collision.geometry));
      }
      least = std::min(least, box.diagonal().norm());
    }
  if (!std::isfinite(least))
    throw BadInput("--voxel: no moving body has a size to take it from; give one");
  return kVoxelOfDiagonal * least;
}

}  // namespace cloudcontact::program
