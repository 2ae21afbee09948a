// Reads, digitizes and looks up tissues, once for each different geometry.
#include "scene/scene_clouds.h"

#include <cloudcontact/mesh/mesh_repair.h>
#include <cloudcontact/voxels/digitize.h>
#include <cloudcontact/voxels/display_mesh.h>
#include <cloudcontact/voxels/matter_sums.h>

#include <algorithm>
#include <iostream>
#include <set>
#include <sstream>

#include "io/errors.h"
#include "io/progress.h"
#include "io/text.h"
#include "scene/primitive_mesh.h"
#include "scene/shape_cache.h"
#include "scene/tissue_file.h"

namespace cloudcontact::program {
namespace {

constexpr double kMeshTolerance = 0.002;  // of primitives' meshes [voxels]
// A static mesh so many times as long as the longest geometry that moves needs no voxels: about a
// hundredth of its surface is touched at a time, and voxels of all would take most of the start.
constexpr double kLarge = 10;

std::string keyOfVector(const Vec3& v) {
  std::ostringstream key;
  key << std::hexfloat << " p " << v.transpose();
  return key.str();
}

std::string keyOfTurn(const Eigen::Quaterniond& q) {
  std::ostringstream key;
  key << std::hexfloat << " q " << q.coeffs().transpose();
  return key.str();
}

template <class Named>
std::string listOf(const Named& entries, std::string (*name)(const typename Named::value_type&)) {
  std::string list;
  for (const auto& entry : entries) list += (list.empty() ? "" : ", ") + printable(name(entry));
  return list;
}

// The pairs of part and tissue that tissuesOfParts() takes.
std::vector<std::pair<std::string, std::string>> pairsOf(const SceneCollision& collision,
                                                         const std::vector<std::string>& parts) {
  std::vector<std::pair<std::string, std::string>> pairs;
  const auto isNamed = [&](const std::string& part) {
    return std::any_of(collision.tissues.begin(), collision.tissues.end(),
                       [&](const SceneTissue& t) { return t.part == part; });
  };
  for (const SceneTissue& tissue : collision.tissues) {
    if (!tissue.part.empty()) {
      pairs.emplace_back(tissue.part, tissue.name);
    } else if (parts.empty()) {
      pairs.emplace_back("all", tissue.name);
    } else {
      for (const std::string& part : parts)
        if (!isNamed(part)) pairs.emplace_back(part, tissue.name);
    }
  }
  return pairs;
}

// Throws BadInput for a tissue or a part that does not exist.
void refuseTissues(const SceneCollision& collision, const std::vector<std::string>& parts,
                   const TissueTable& table) {
  const std::string where = collision.where + " <cloudcontact:tissue>: ";
  for (const SceneTissue& tissue : collision.tissues) {
    if (std::none_of(table.begin(), table.end(),
                     [&](const Tissue& t) { return t.name == tissue.name; }))
      throw BadInput(where + printable(tissue.name) + " is not in the table of tissues; use " +
                     listOf(
                         table, +[](const Tissue& t) { return t.name; }) +
                     ", or give --tissues FILE.json");
    if (tissue.part.empty() || (parts.empty() && tissue.part == "all") ||
        std::find(parts.begin(), parts.end(), tissue.part) != parts.end())
      continue;
    throw BadInput(where + "there is no part " + printable(tissue.part) + "; " +
                   (parts.empty()
                        ? "the body is one part: leave the attribute part out"
                        : "the parts are " + listOf(
                                                 parts, +[](const std::string& p) { return p; })));
  }
}

// Whether it is cut, cuts, is of a tissue, has base vectors, or asks for its voxels.
bool needsVoxels(const SceneCollision& collision) {
  return collision.isCuttable || collision.cutter || collision.paper.isGiven() ||
         !collision.tissues.empty() || collision.tolerance == 0.0;
}

}  // namespace

bool isMesh(const SceneGeometry& geometry) {
  return std::holds_alternative<SceneMesh>(geometry);
}
bool isPlane(const SceneGeometry& geometry) {
  return std::holds_alternative<ScenePlane>(geometry);
}

SceneTraits traitsOf(const SceneDescription& scene) {
  SceneTraits traits;
  std::set<std::string> known;
  for (const SceneBody& body : scene.bodies) {
    traits.deforms |= body.isSoft();
    traits.compounds |= body.collisions.size() > 1;
    traits.voxels |= std::any_of(body.collisions.begin(), body.collisions.end(), needsVoxels);
    for (const SceneCollision& collision : body.collisions)
      if (!body.isStatic && known.insert(keyOf(collision.geometry)).second)
        traits.moving.emplace_back(collision.geometry, body.name);
  }
  return traits;
}

Solid analytic(const SceneGeometry& geometry) {
  struct Visitor {
    Solid operator()(const SceneBox& b) const { return Box{b.size / 2}; }
    Solid operator()(const SceneSphere& s) const { return Sphere{s.radius}; }
    Solid operator()(const SceneCylinder& c) const { return Cylinder{c.radius, c.length / 2}; }
    Solid operator()(const SceneCapsule& c) const { return Capsule{c.radius, c.length / 2}; }
    Solid operator()(const SceneCone& c) const { return Cone{c.radius, c.length / 2}; }
    Solid operator()(const ScenePlane& p) const { return HalfSpace{p.normal, 0}; }
    Solid operator()(const SceneMesh&) const { return Hull{}; }
  };
  return std::visit(Visitor{}, geometry);
}

Mesh moved(const Mesh& mesh, const Pose& pose) {
  Mesh out = mesh;
  for (Vec3& v : out.vertices) v = pose.toWorld(v);
  return out;
}

std::string keyOf(const SceneGeometry& geometry) {
  std::ostringstream key;
  key << std::hexfloat << geometry.index();
  struct Visitor {
    std::ostream& out;
    void operator()(const SceneBox& b) const { out << ' ' << b.size.transpose(); }
    void operator()(const SceneSphere& s) const { out << ' ' << s.radius; }
    void operator()(const SceneCylinder& c) const { out << ' ' << c.radius << ' ' << c.length; }
    void operator()(const SceneCapsule& c) const { out << ' ' << c.radius << ' ' << c.length; }
    void operator()(const SceneCone& c) const { out << ' ' << c.radius << ' ' << c.length; }
    void operator()(const ScenePlane& p) const { out << ' ' << p.normal.transpose(); }
    void operator()(const SceneMesh& m) const {
      out << ' ' << m.file.string() << ' ' << m.scale.transpose();
      for (const CtRange& range : m.thresholds) out << ' ' << range.name << '=' << range.from;
    }
  };
  std::visit(Visitor{key}, geometry);
  return key.str();
}

std::string keyOf(const Pose& pose) {
  return keyOfTurn(pose.orientation) + keyOfVector(pose.position);
}

// Of a file as it is now.
std::string stampOf(const std::filesystem::path& file) {
  std::error_code none;
  const auto written = std::filesystem::last_write_time(file, none).time_since_epoch().count();
  return ' ' + std::to_string(written) + ' ' +
         std::to_string(std::filesystem::file_size(file, none));
}

// Of a cloud that its field keeps: clouds of equal matter share their voxels.
std::string keyOf(const Cloud& cloud) {
  return std::to_string(reinterpret_cast<std::uintptr_t>(&cloud.voxels())) +
         keyOfVector(cloud.origin());
}

SceneClouds::SceneClouds(const CommonOptions& options, double voxel,
                         std::shared_ptr<ShapeStore> store, const SceneTraits& traits)
    : options_(options),
      voxel_(voxel),
      store_(store ? std::move(store) : std::make_shared<ShapeStore>()),
      traits_(traits),
      tissues_(options.tissues) {}

bool SceneClouds::meetsAsShape(const SceneCollision& collision, const SceneBody& body) {
  if (isPlane(collision.geometry)) return true;
  if (!body.isStatic) return false;
  const SceneGeometry& shape = collision.geometry;
  if (isMesh(shape) &&
      (options_.shell || !(isOpenMesh(shape, body.name) || isLarge(shape, body.name))))
    return false;
  return !traits_.deforms && options_.method != Method::Paper && !needsVoxels(collision) &&
         tissues(collision, body.name).empty();
}

double SceneClouds::voxelOf(const SceneGeometry& geometry) const {
  constexpr double kThick = 12, kLong = 128;  // [voxels]
  const bool count = traits_.deforms || traits_.voxels || options_.exact ||
                     options_.method == Method::Paper || !options_.tissues.ofParts.empty() ||
                     std::holds_alternative<Foundation>(options_.law);
  if (count || isMesh(geometry) || isPlane(geometry)) return voxel_;
  const Vec3 size = boundsOf(analytic(geometry)).sizes();
  return std::max(voxel_, std::min(size.minCoeff() / kThick, size.maxCoeff() / kLong));
}

// Null for primitives, planes and meshes made in memory.
const Body* SceneClouds::file(const SceneGeometry& geometry, const std::string& body) {
  const auto* named = std::get_if<SceneMesh>(&geometry);
  if (!named || named->mesh) return nullptr;
  Body& kept = files_[named->file.string()];
  if (kept.name.empty() && named->cloud)
    kept.name = named->file.string(), kept.cloud = *named->cloud;
  else if (kept.name.empty())
    kept = naming(body, [&] { return readBody(named->file.string(), options_); });
  if (!kept.mesh && named->scale != Vec3::Ones())
    throw BadInput("body '" + body + "' <scale>: " + kept.name +
                   " holds no mesh, so its scale must be 1; leave <scale> out");
  return &kept;
}

bool SceneClouds::isDigital(const SceneGeometry& geometry, const std::string& body) {
  const Body* known = file(geometry, body);
  return known && !known->mesh;
}

const SceneClouds::Mended& SceneClouds::mendedMesh(const SceneGeometry& geometry,
                                                   const std::string& body) {
  Mended& kept = mended_[keyOf(geometry)];
  if (!kept.mesh)
    naming(body, [&] {
      const auto& named = std::get<SceneMesh>(geometry);
      const Mesh mesh = named.mesh ? *named.mesh : *file(geometry, body)->mesh;
      kept.mesh = std::make_shared<const Mesh>(mended(mesh.scaled(named.scale), 0, &kept.isSheet));
    });
  return kept;
}

bool SceneClouds::isOpenMesh(const SceneGeometry& geometry, const std::string& body) {
  return isMesh(geometry) && !isDigital(geometry, body) && mendedMesh(geometry, body).isSheet;
}

double SceneClouds::sizeOf(const SceneGeometry& geometry, const std::string& body) {
  if (isPlane(geometry)) return 0;
  if (!isMesh(geometry)) return boundsOf(analytic(geometry)).diagonal().norm();
  const auto& named = std::get<SceneMesh>(geometry);
  Body made;
  const Body* known = file(geometry, body);
  if (!known) made.mesh = *named.mesh, known = &made;
  return boundsOf(*known).diagonal().cwiseProduct(named.scale).norm();
}

bool SceneClouds::isLarge(const SceneGeometry& geometry, const std::string& body) {
  if (isDigital(geometry, body) || traits_.moving.empty()) return false;
  if (!largestMoving_) {
    largestMoving_ = 0;
    for (const auto& [moving, name] : traits_.moving)
      largestMoving_ = std::max(*largestMoving_, sizeOf(moving, name));
  }
  return sizeOf(geometry, body) > kLarge * *largestMoving_;
}

std::shared_ptr<const Mesh> SceneClouds::triangles(const SceneGeometry& geometry,
                                                   const std::string& body) {
  return mendedMesh(geometry, body).mesh;
}

std::shared_ptr<const Mesh> SceneClouds::mesh(const SceneGeometry& geometry,
                                              const std::string& body) {
  auto& kept = meshes_[keyOf(geometry)];
  if (kept) return kept;
  return kept = naming(body, [&] {
           if (!isMesh(geometry))
             return std::make_shared<const Mesh>(
                 primitiveMesh(analytic(geometry), kMeshTolerance * voxelOf(geometry)));
           const Mended& mended = mendedMesh(geometry, body);
           if (!mended.isSheet) return mended.mesh;
           const double thickness = options_.shell.value_or(3 * voxel_);
           std::cerr << "cloudcontact: " << std::get<SceneMesh>(geometry).file.string()
                     << " has no inside; made a shell " << thickness
                     << " m thick behind its faces (--shell)\n";
           return std::make_shared<const Mesh>(shell(*mended.mesh, thickness));
         });
}

std::shared_ptr<const Mesh> SceneClouds::drawn(const SceneGeometry& geometry,
                                               const std::string& body) {
  auto& kept = drawn_[keyOf(geometry)];
  if (!kept)
    kept = std::make_shared<const Mesh>(
        mended(DisplayMesh(cloud(geometry, Pose(), body).cloud, options_.threads).mesh()));
  return kept;
}

// The parts of a mesh file that has several; none if it is a sheet, whose shell is one part.
std::vector<NamedMesh> SceneClouds::parts(const SceneGeometry& geometry, const std::string& body) {
  const Body* known = file(geometry, body);
  if (!known || known->parts.empty() || isSheet(*known->mesh)) return {};
  std::vector<NamedMesh> parts = known->parts;
  for (NamedMesh& part : parts) part.mesh = part.mesh.scaled(std::get<SceneMesh>(geometry).scale);
  return parts;
}

namespace {

// Of the numbers in a mesh file [m]; not 1 if the scene scales them.
double unitOf(const SceneGeometry& geometry, const CommonOptions& options) {
  const auto* const mesh = std::get_if<SceneMesh>(&geometry);
  return mesh && mesh->scale == Vec3::Ones() ? options.metersPerUnit : 0;
}

}  // namespace

// A mesh, turned about the origin.
Cloud SceneClouds::digitized(const SceneGeometry& geometry, const Pose& turn,
                             const std::string& body) {
  DigitizeSettings settings;
  const double voxel = voxelOf(geometry);
  settings.voxelSize = voxel;
  settings.threads = options_.threads;
  std::vector<NamedMesh> turned = parts(geometry, body);
  std::string key = keyOfVector(Vec3(voxel, 0, 0));
  if (turned.empty()) {
    const Mesh whole = moved(*mesh(geometry, body), turn);
    return store_->clouds.get(contentKey(whole) + key, [&] {
      settings.progress = options_.progress("digitizing " + body);
      const auto make = [&] {
        return askingUnit(whole, voxel, unitOf(geometry, options_),
                          [&] { return digitize(whole, settings); });
      };
      return options_.cache ? options_.cache->cloud(whole, voxel, make) : make();
    });
  }
  for (NamedMesh& part : turned) {
    part.mesh = moved(part.mesh, turn);
    key += contentKey(part.mesh) + part.name;
  }
  return store_->clouds.get(key, [&] {
    settings.progress = options_.progress("digitizing " + body);
    const auto make = [&] { return digitize(turned, settings); };
    return options_.cache ? options_.cache->cloud(turned, voxel, make) : make();
  });
}

Cloud SceneClouds::objectCloud(const SceneMesh& geometry, const std::string& body) {
  const Body& object = *file(geometry, body);
  CommonOptions options = options_;
  if (!geometry.thresholds.empty()) options.thresholds = geometry.thresholds;
  options.voxel.reset();  // saved voxels keep their size, beside bodies of another
  const double voxel = options_.voxel && !object.cloud ? voxel_ : program::defaultVoxel(object);
  const auto make = [&] { return digitizeBody(object, voxel, options).cloud; };
  if (geometry.cloud) return make();
  std::string key = keyOf(SceneGeometry(geometry)) + stampOf(geometry.file) +
                    keyOfVector(Vec3(voxel, options.metersPerUnit, options.shell.value_or(0)));
  for (const CtRange& range : options.thresholds)
    key += ' ' + range.name + '=' + std::to_string(range.from);
  return store_->clouds.get(key, make);
}

// Digitizes a mesh once for each orientation; positions share the cloud.
PlacedCloud SceneClouds::cloud(const SceneGeometry& geometry, const Pose& pose,
                               const std::string& body) {
  const bool digital = isDigital(geometry, body);
  Cloud& kept = clouds_[digital ? keyOf(geometry) : keyOf(geometry) + keyOfTurn(pose.orientation)];
  if (kept.empty())
    kept = naming(body, [&] {
      return digital ? objectCloud(std::get<SceneMesh>(geometry), body)
                     : digitized(geometry, {pose.orientation, Vec3::Zero()}, body);
    });
  if (digital) return {kept, pose};
  return {kept.translated(pose.position), Pose()};
}

PlacedField SceneClouds::field(const SceneGeometry& geometry, const Pose& pose,
                               const std::string& body) {
  const bool digital = isDigital(geometry, body);
  const Pose place = digital ? pose : Pose();
  if (const auto* named = std::get_if<SceneMesh>(&geometry); named && named->field)
    return {named->field, place};
  auto& kept = fields_[digital ? keyOf(geometry) : keyOf(geometry) + keyOf(pose)];
  if (kept) return {kept, place};
  const Cloud matter = cloud(geometry, pose, body).cloud;
  kept = store_->fields.get(keyOf(matter), [&] { return buildField(matter, body, options_); });
  return {kept, place};
}

PlacedLevels SceneClouds::levels(const SceneGeometry& geometry, const Pose& pose,
                                 const std::string& body) {
  const bool digital = isDigital(geometry, body);
  auto& kept = levels_[digital ? keyOf(geometry) : keyOf(geometry) + keyOf(pose)];
  if (!kept) {
    FieldSettings how;
    how.threads = options_.threads;
    const Cloud matter = cloud(geometry, pose, body).cloud;
    const auto make = [cache = options_.cache](const Cloud& level, const FieldSettings& settings) {
      const auto build = [&] { return SurfaceField::build(level, settings); };
      return cache ? cache->field(level, build) : build();
    };
    kept = store_->levels.get(
        keyOf(matter), [&] { return std::make_shared<const FieldLevels>(matter, how, make); });
  }
  return {kept, digital ? pose : Pose()};
}

TissueTable SceneClouds::tissues(const SceneCollision& collision, const std::string& body) {
  std::vector<std::string> parts;  // a primitive is one, and so is a mesh that has no others
  if (isDigital(collision.geometry, body) || !this->parts(collision.geometry, body).empty())
    parts = cloud(collision.geometry, collision.pose, body).cloud.materials();
  if (collision.tissues.empty()) return tissues_.of(body, parts);
  if (!table_) table_ = tableOf(options_.tissues, "dental");
  refuseTissues(collision, parts, *table_);
  return tissuesOfParts(collision.where, *table_, parts, pairsOf(collision, parts));
}

void SceneClouds::checkTissues() const {
  // A table may be there for the scene's elements alone.
  if (table_ && options_.tissues.ofParts.empty()) return;
  tissues_.check();
}

MassProperties SceneClouds::matter(const SceneCollision& collision, const std::string& body,
                                   bool atDensities) {
  const auto [cloud, place] = this->cloud(collision.geometry, collision.pose, body);
  std::vector<double> densities;
  if (atDensities)
    for (const Tissue& tissue : tissues(collision, body)) densities.push_back(tissue.density);
  if (densities.empty()) densities = {1};
  const MassProperties matter = massPropertiesOf(cloud, densities);
  return isDigital(collision.geometry, body) ? placed(matter, place) : matter;
}

}  // namespace cloudcontact::program
