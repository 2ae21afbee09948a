// Reads SDFormat worlds and URDF robots with libsdformat.
#include "scene/scene_file.h"

#include <cmath>
#include <functional>
#include <iostream>
#include <map>
#include <sdf/sdf.hh>
#include <set>
#include <sstream>

#include "io/errors.h"
#include "scene/robot_text.h"
#include "scene/scene_check.h"
#include "scene/scene_elements.h"
#include "scene/scene_paths.h"
#include "scene/scene_text.h"
#include "scene/sdf_joint.h"
#include "scene/sdf_tree.h"
#include "scene/sdf_values.h"

namespace cloudcontact::program {
namespace {

// Discards std::cerr output while it exists: libsdformat tries invalid files as robot descriptions
// and complains about those.
class SilencedErrors {
 public:
  SilencedErrors() : kept_(std::cerr.rdbuf(nullptr)) {}
  ~SilencedErrors() { std::cerr.rdbuf(kept_); }
  SilencedErrors(const SilencedErrors&) = delete;
  SilencedErrors& operator=(const SilencedErrors&) = delete;

 private:
  std::streambuf* kept_;
};

// Reads one file. Resolves mesh paths.
class SceneReader {
 public:
  SceneReader(const std::filesystem::path& file, std::string text)
      : file_(file), text_(std::move(text)), in_(file.string()) {}

  SceneDescription read();

 private:
  bool isRobot() const { return isRobotFile(file_); }
  void load(sdf::Root& root);
  void readWorld(const sdf::World& world);
  void readModel(const sdf::Model& model, const std::string& scope, const Pose& parent,
                 bool parentStatic);
  void readLink(const sdf::Model& model, const sdf::Link& link, const std::string& scope,
                const Pose& modelPose, bool isStatic);
  void readInertial(const sdf::Link& link, SceneBody& body) const;
  void readCollision(const sdf::Collision& collision, SceneBody& body) const;
  void readVisuals(const sdf::Link& link, SceneBody& body) const;
  void readDrive(const sdf::Link& link, const Pose& linkInBody, SceneBody& body) const;
  void checkCutting(const SceneBody& body) const;
  void checkSoft(const SceneBody& body) const;
  void readSurface(const sdf::ElementPtr& surface, const std::string& element,
                   SceneBody& body) const;
  SceneGeometry readGeometry(const sdf::Geometry& geometry, const std::string& element) const;
  SceneMesh readMesh(const sdf::Mesh& mesh, const std::string& element) const;
  void readState(const sdf::ElementPtr& state);
  int bodyIndex(const std::string& link, const std::string& scope,
                const std::string& element) const;

  std::filesystem::path file_;
  std::string text_;  // of the file
  SdfValues in_;
  SceneDescription scene_;
  std::set<std::string> massless_;  // links of a robot whose mass is their voxels'
  struct LinkPlace {
    int body;
    Vec3 origin;  // of the link in the body's frame
  };
  std::map<std::string, LinkPlace> links_;  // by full name
};

void SceneReader::load(sdf::Root& root) {
  RobotText robot{text_, {}};
  if (isRobot()) {
    try {
      robot = withMasses(robot.text);
    } catch (const std::invalid_argument& why) {
      throw BadInput(file_.string() + ": " + why.what());
    }
    massless_ = robot.standIns;
  }
  sdf::ParserConfig config;
  const auto folder = std::filesystem::absolute(file_).parent_path();
  config.SetFindCallback([folder](const std::string& uri) {
    const auto path = folder / uri;
    return std::filesystem::exists(path) ? path.string() : std::string();
  });
  // Otherwise libsdformat ignores a misspelled element, and the body gets another mass or surface.
  config.SetUnrecognizedElementsPolicy(sdf::EnforcementPolicy::ERR);
  const std::string invalid =
      isRobot() ? "not valid URDF, correct it" : "not valid SDFormat, correct it";
  const sdf::SDFPtr tree = emptySdfTree();
  const auto errors = [&] {
    const SilencedErrors silence;
    try {
      // libsdformat resolves relative paths by $PWD, which may differ from the working directory.
      sdf::Errors all;
      const bool read =
          isRobot() ? sdf::readString(robot.text, config, tree, all)
                    : sdf::readFile(std::filesystem::absolute(file_).string(), config, tree, all);
      if (!read && all.empty()) all.emplace_back(sdf::ErrorCode::STRING_READ, "it is no XML");
      if (!read) return all;
      const sdf::Errors found = root.Load(tree, config);
      all.insert(all.end(), found.begin(), found.end());
      return all;
    } catch (const std::exception& why) {  // a version that is no number
      throw BadInput(file_.string() + ": " + invalid + ": " + why.what());
    }
  }();
  in_.check(errors, invalid);
  if (isRobot() && !root.Model()) in_.fail("<robot>", "has no link with a mass; add one");
  if (!isRobot() && root.WorldCount() != 1)
    in_.fail("<sdf>", "has " + std::to_string(root.WorldCount()) +
                          " worlds; put the models in exactly one <world>");
}

SceneDescription SceneReader::read() {
  sdf::Root root;
  load(root);
  if (!isRobot()) {
    readWorld(*root.WorldByIndex(0));
  } else {
    scene_.name = root.Model()->Name();
    readModel(*root.Model(), "", Pose(), false);
  }
  return std::move(scene_);
}

void SceneReader::readWorld(const sdf::World& world) {
  const auto element = world.Element();
  if (element) checkOwnElements(file_.string(), element);
  scene_.name = world.Name();
  scene_.gravity = in_.vector(world.Gravity(), "<gravity>");
  if (const auto* physics = world.PhysicsDefault())
    scene_.step = in_.positive(physics->MaxStepSize(), "<physics> <max_step_size>");
  for (std::uint64_t i = 0; i < world.ModelCount(); ++i)
    readModel(*world.ModelByIndex(i), "", Pose(), false);
  if (scene_.bodies.empty()) in_.fail("<world>", "has no model with a link; add one");
  if (element && element->HasElement("state")) readState(element->GetElement("state"));
}

void SceneReader::readModel(const sdf::Model& model, const std::string& scope, const Pose& parent,
                            bool parentStatic) {
  const std::string name = scope + model.Name();
  const Pose modelPose = parent * in_.resolved(model.SemanticPose(), "", "model '" + name + "'");
  const bool isStatic = parentStatic || model.Static();
  for (std::uint64_t i = 0; i < model.LinkCount(); ++i)
    readLink(model, *model.LinkByIndex(i), name, modelPose, isStatic);
  for (std::uint64_t i = 0; i < model.ModelCount(); ++i)
    readModel(*model.ModelByIndex(i), name + "::", modelPose, isStatic);
  for (std::uint64_t i = 0; i < model.JointCount(); ++i)
    scene_.joints.push_back(readJoint(in_, *model.JointByIndex(i), name, modelPose,
                                      [&](const std::string& link, const std::string& element) {
                                        return bodyIndex(link, name, element);
                                      }));
}

void SceneReader::readLink(const sdf::Model& model, const sdf::Link& link, const std::string& scope,
                           const Pose& modelPose, bool isStatic) {
  SceneBody body;
  const std::string full = scope + "::" + link.Name();
  const std::string element = "link '" + full + "'";
  const Pose linkInModel = in_.resolved(link.SemanticPose(), "", element);
  const bool alone = model.LinkCount() == 1;
  body.name = alone ? scope : full;
  body.pose = alone ? modelPose : modelPose * linkInModel;
  body.isStatic = isStatic;
  body.selfCollide = model.SelfCollide();
  // A model's links share a number; nested models count as models of their own.
  body.model = scene_.bodies.empty() ? 0 : scene_.bodies.back().model + 1;
  if (model.LinkByIndex(0) != &link) body.model = scene_.bodies.back().model;
  readInertial(link, body);
  const Pose linkInBody = alone ? linkInModel : Pose();
  readDrive(link, linkInBody, body);
  for (std::uint64_t i = 0; i < link.CollisionCount(); ++i)
    readCollision(*link.CollisionByIndex(i), body);
  if (body.collisions.empty()) readVisuals(link, body);
  checkCutting(body);
  checkSoft(body);
  if (body.inertialPose)
    body.inertialPose = linkInBody * *body.inertialPose;
  else if (body.inertia)
    body.inertialPose = linkInBody;
  for (auto* parts : {&body.collisions, &body.visuals})
    for (SceneCollision& part : *parts) part.pose = linkInBody * part.pose;
  links_[full] = {static_cast<int>(scene_.bodies.size()), linkInBody.position};
  scene_.bodies.push_back(std::move(body));
}

void SceneReader::readInertial(const sdf::Link& link, SceneBody& body) const {
  const auto element = link.Element();
  if (!element || !element->HasElement("inertial") || massless_.contains(link.Name())) return;
  const auto inertial = element->GetElement("inertial");
  const std::string name = "link '" + body.name + "' <inertial>";
  const auto& value = link.Inertial();
  if (inertial->HasElement("mass"))
    body.mass = in_.positive(value.MassMatrix().Mass(), name + " <mass>");
  if (inertial->HasElement("pose")) body.inertialPose = in_.pose(value.Pose(), name + " <pose>");
  if (!inertial->HasElement("inertia")) return;
  const auto moi = value.MassMatrix().Moi();
  Eigen::Matrix3d inertia;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) inertia(r, c) = moi(r, c);
  if (!inertia.allFinite()) in_.fail(name + " <inertia>", "not finite; give finite numbers");
  if (!body.mass) in_.fail(name, "gives <inertia> without <mass>; add the mass");
  body.inertia = inertia;
}

void SceneReader::readCollision(const sdf::Collision& collision, SceneBody& body) const {
  SceneCollision out;
  const std::string element = "body '" + body.name + "' collision '" + collision.Name() + "'";
  out.name = collision.Name();
  out.where = file_.string() + ": " + element;
  // In the frame of its link.
  out.pose = in_.resolved(collision.SemanticPose(), "", element);
  if (!collision.Geom()) in_.fail(element, "has no <geometry>; add one");
  out.geometry = readGeometry(*collision.Geom(), element);
  if (std::holds_alternative<ScenePlane>(out.geometry) && body.isFree())
    in_.fail(element, "a <plane> has no mass: make its model <static>true</static>");
  const auto sdfElement = collision.Element();
  if (sdfElement) readOwnElements(out.where, sdfElement, out);
  if (sdfElement && sdfElement->HasElement("surface"))
    readSurface(sdfElement->GetElement("surface"), element, body);
  body.collisions.push_back(std::move(out));
}

// What nothing touches is seen only where its model says how it looks. What cannot be read is not
// seen.
void SceneReader::readVisuals(const sdf::Link& link, SceneBody& body) const {
  for (std::uint64_t i = 0; i < link.VisualCount(); ++i) try {
      const sdf::Visual& visual = *link.VisualByIndex(i);
      const std::string element = "body '" + body.name + "' visual '" + visual.Name() + "'";
      if (!visual.Geom() || visual.Geom()->Type() == sdf::GeometryType::PLANE) continue;
      body.visuals.push_back({visual.Name(), in_.resolved(visual.SemanticPose(), "", element),
                              readGeometry(*visual.Geom(), element)});
    } catch (const BadInput& why) {
      std::cerr << "cloudcontact: " << why.what() << " (it is not drawn)\n";
    }
}

void SceneReader::readDrive(const sdf::Link& link, const Pose& linkInBody, SceneBody& body) const {
  const std::string element = "link '" + body.name + "'";
  if (!link.Element()) return;
  body.drive = program::readDrive(file_.string() + ": " + element, link.Element(), linkInBody);
  if (body.drive && body.isStatic)
    in_.fail(element + " <cloudcontact:drive>",
             "a static model does not move; leave <static> or the drive out");
}

// What is cut is one cloud with a mass, which its matter decides.
void SceneReader::checkCutting(const SceneBody& body) const {
  for (const SceneCollision& collision : body.collisions) {
    const bool isPlane = std::holds_alternative<ScenePlane>(collision.geometry);
    const std::string element = "body '" + body.name + "' collision '" + collision.name + "' ";
    if (isPlane && (collision.cutter || collision.isCuttable || !collision.tissues.empty()))
      in_.fail(element, "a <plane> has no voxels to cut or to be of a tissue; use a <box>");
    if (!collision.isCuttable) continue;
    const std::string name = element + "<cloudcontact:cuttable>";
    if (body.collisions.size() > 1)
      in_.fail(name, "the link has other collisions; give a body that is cut one collision");
    if (body.drive) in_.fail(name, "the link has a drive; cut what is free or <static>");
    if (body.inertia || body.inertialPose)
      in_.fail(name, "its <inertial> follows from its matter; give a <mass> alone, or nothing");
  }
}

// Soft tissue has the shape, the mass and the frame of its matter.
void SceneReader::checkSoft(const SceneBody& body) const {
  for (const SceneCollision& collision : body.collisions) {
    if (!collision.soft) continue;
    const std::string name =
        "body '" + body.name + "' collision '" + collision.name + "' <cloudcontact:soft>";
    if (std::holds_alternative<ScenePlane>(collision.geometry))
      in_.fail(name, "a <plane> has no matter; use a <box>");
    if (body.collisions.size() > 1)
      in_.fail(name, "the link has other collisions; give a body that deforms one collision");
    if (!body.isFree())
      in_.fail(name, "the model is <static> or has a drive; hold its sides by the attribute held");
    if (body.inertia || body.inertialPose)
      in_.fail(name, "its <inertial> follows from its matter; give a <mass> alone, or nothing");
    if (body.stiffness) in_.fail(name, "its <kp> follows from its tissues; leave it out");
    if (collision.paper.isGiven())
      in_.fail(name, "only what does not deform has windows and areas; leave them out");
    if (collision.tissues.empty())
      in_.fail(name, "its tissue is missing, whose elasticity it has; add a <cloudcontact:tissue>");
  }
}

void SceneReader::readSurface(const sdf::ElementPtr& surface, const std::string& element,
                              SceneBody& body) const {
  const auto take = [&](std::initializer_list<const char*> path, std::optional<double>& field) {
    const auto found = descend(surface, path);
    if (!found) return;
    const std::string name = element + " <" + *(path.end() - 1) + ">";
    const double value = found->Get<double>();
    if (!std::isfinite(value) || value < 0)
      in_.fail(name, "must be a finite number of 0 or more, is " + std::to_string(value));
    if (field && *field != value)
      in_.fail(name, "differs from the body's other collisions; a body has one surface here");
    field = value;
  };
  // ODE's elements are the format's standard; Bullet's apply if those are missing.
  if (descend(surface, {"friction", "ode", "mu"}))
    take({"friction", "ode", "mu"}, body.friction);
  else
    take({"friction", "bullet", "friction"}, body.friction);
  take({"contact", "ode", "kp"}, body.stiffness);
  take({"contact", "ode", "kd"}, body.damping);
  take({"bounce", "restitution_coefficient"}, body.restitution);
  if (body.restitution && *body.restitution > 1)
    in_.fail(element + " <restitution_coefficient>",
             "must be at most 1, is " + std::to_string(*body.restitution));
  if (body.stiffness && *body.stiffness == 0)
    in_.fail(element + " <kp>", "is 0: the contact would have no force; give a stiffness in N/m");
}

SceneGeometry SceneReader::readGeometry(const sdf::Geometry& geometry,
                                        const std::string& element) const {
  switch (geometry.Type()) {
    case sdf::GeometryType::BOX: {
      const Vec3 size = in_.vector(geometry.BoxShape()->Size(), element + " <box> <size>");
      in_.positive(size.minCoeff(), element + " <box> <size>");
      return SceneBox{size};
    }
    case sdf::GeometryType::SPHERE:
      return SceneSphere{
          in_.positive(geometry.SphereShape()->Radius(), element + " <sphere> <radius>")};
    case sdf::GeometryType::CYLINDER: {
      const auto* shape = geometry.CylinderShape();
      return SceneCylinder{in_.positive(shape->Radius(), element + " <cylinder> <radius>"),
                           in_.positive(shape->Length(), element + " <cylinder> <length>")};
    }
    case sdf::GeometryType::CAPSULE: {
      const auto* shape = geometry.CapsuleShape();
      return SceneCapsule{in_.positive(shape->Radius(), element + " <capsule> <radius>"),
                          in_.positive(shape->Length(), element + " <capsule> <length>")};
    }
    case sdf::GeometryType::PLANE: {
      const Vec3 normal =
          in_.vector(geometry.PlaneShape()->Normal(), element + " <plane> <normal>");
      in_.positive(normal.norm(), element + " <plane> <normal>");
      return ScenePlane{normal.normalized()};
    }
    case sdf::GeometryType::MESH:
      return readMesh(*geometry.MeshShape(), element + " <mesh>");
    default:
      in_.fail(element + " <geometry>",
               "is of a kind not known here; use box, sphere, cylinder, capsule, plane or mesh");
  }
}

SceneMesh SceneReader::readMesh(const sdf::Mesh& mesh, const std::string& element) const {
  const std::string uri = pathOf(mesh.Uri(), file_.parent_path());
  if (uri.empty()) in_.fail(element + " <uri>", "is empty; name a mesh file");
  if (uri.find("://") != std::string::npos)
    in_.fail(element + " <uri>", "'" + uri + "' is no path; give one relative to the scene file");
  if (!mesh.Submesh().empty())
    in_.fail(element + " <submesh>", "is not known here; put the part in a file of its own");
  SceneMesh out;
  out.file = (file_.parent_path() / uri).lexically_normal();
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(out.file, ignored))
    in_.fail(element + " <uri>",
             "no file '" + out.file.string() + "'; paths are relative to the scene");
  out.scale = in_.vector(mesh.Scale(), element + " <scale>");
  in_.positive(out.scale.minCoeff(), element + " <scale>");
  return out;
}

int SceneReader::bodyIndex(const std::string& link, const std::string& scope,
                           const std::string& element) const {
  if (link == "world") return -1;
  const auto found = links_.find(scope + "::" + link);
  if (found == links_.end()) in_.fail(element, "no link '" + link + "' in model '" + scope + "'");
  return found->second.body;
}

// Initial velocities: <state><model name><link name><velocity>, linear then angular.
void SceneReader::readState(const sdf::ElementPtr& state) {
  for (auto model = descend(state, {"model"}); model; model = model->GetNextElement("model")) {
    const std::string modelName = model->Get<std::string>("name");
    for (auto link = descend(model, {"link"}); link; link = link->GetNextElement("link")) {
      const std::string full = modelName + "::" + link->Get<std::string>("name");
      const auto found = links_.find(full);
      if (found == links_.end()) in_.fail("<state>", "no link '" + full + "' in this world");
      const auto velocity = descend(link, {"velocity"});
      if (!velocity) continue;
      const std::string element = "<state> link '" + full + "' <velocity>";
      std::istringstream numbers(velocity->GetValue()->GetAsString());
      Eigen::Matrix<double, 6, 1> v;
      for (int i = 0; i < 6; ++i)
        if (!(numbers >> v[i]) || !std::isfinite(v[i]))
          in_.fail(element, "needs six finite numbers: linear [m/s], then angular [rad/s]");
      SceneBody& body = scene_.bodies[found->second.body];
      if (body.drive)
        in_.fail(element, "the link has a <cloudcontact:drive>; leave one of them out");
      const Vec3 linear = v.head<3>(), angular = v.tail<3>();
      body.angularVelocity = angular;
      // Given at the link's origin.
      body.linearVelocity = linear - angular.cross(body.pose.orientation * found->second.origin);
    }
  }
}

}  // namespace

namespace {

SceneDescription readScene(const std::filesystem::path& file, const std::string& text) {
  SceneDescription scene = SceneReader(file, text).read();
  try {
    validate(scene);
  } catch (const BadInput& why) {
    throw BadInput(file.string() + ": " + why.what() + "; change it");
  }
  return scene;
}

}  // namespace

SceneDescription loadScene(const std::filesystem::path& file) {
  return readScene(file, sceneText(file));
}

SceneDescription robotOf(const std::string& name, const std::string& text) {
  return readScene(name + ".urdf", text);
}

}  // namespace cloudcontact::program
