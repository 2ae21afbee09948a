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

// Reads one file. Resolves mesh paths and names elements in errors.
class SceneReader {
 public:
  explicit SceneReader(std::filesystem::path file) : file_(std::move(file)) {}

  SceneDescription read();

 private:
  [[noreturn]] void fail(const std::string& element, const std::string& what) const {
    throw BadInput(file_.string() + ": " + element + ": " + what);
  }
  void check(const sdf::Errors& errors, const std::string& element) const;
  bool isRobot() const { return isRobotFile(file_); }
  void load(sdf::Root& root);
  void readWorld(const sdf::World& world);
  void readModel(const sdf::Model& model, const std::string& scope, const Pose& parent,
                 bool parentStatic);
  void readLink(const sdf::Model& model, const sdf::Link& link, const std::string& scope,
                const Pose& modelPose, bool isStatic);
  void readInertial(const sdf::Link& link, SceneBody& body) const;
  void readCollision(const sdf::Collision& collision, SceneBody& body) const;
  void readDrive(const sdf::Link& link, const Pose& linkInBody, SceneBody& body) const;
  void checkCutting(const SceneBody& body) const;
  void checkSoft(const SceneBody& body) const;
  void readSurface(const sdf::ElementPtr& surface, const std::string& element,
                   SceneBody& body) const;
  SceneGeometry readGeometry(const sdf::Geometry& geometry, const std::string& element) const;
  SceneMesh readMesh(const sdf::Mesh& mesh, const std::string& element) const;
  void readJoint(const sdf::Joint& joint, const std::string& scope, const Pose& modelPose);
  void readDynamics(const sdf::JointAxis& axis, const std::string& element,
                    SceneJoint& joint) const;
  void readState(const sdf::ElementPtr& state);
  int bodyIndex(const std::string& link, const std::string& scope,
                const std::string& element) const;

  Vec3 vector(const ignition::math::Vector3d& v, const std::string& element) const;
  Pose pose(const ignition::math::Pose3d& p, const std::string& element) const;
  Pose resolved(const sdf::SemanticPose& semantic, const std::string& frame,
                const std::string& element) const;
  double positive(double value, const std::string& element) const;

  std::filesystem::path file_;
  SceneDescription scene_;
  std::set<std::string> massless_;  // links of a robot whose mass is their voxels'
  struct LinkPlace {
    int body;
    Vec3 origin;  // of the link in the body's frame
  };
  std::map<std::string, LinkPlace> links_;  // by full name
};

void SceneReader::check(const sdf::Errors& errors, const std::string& element) const {
  if (errors.empty()) return;
  std::string message = errors.front().Message();
  for (char& c : message)
    if (c == '\n') c = ' ';
  if (errors.size() > 1) message += " (and " + std::to_string(errors.size() - 1) + " more)";
  fail(element, message);
}

Vec3 SceneReader::vector(const ignition::math::Vector3d& v, const std::string& element) const {
  const Vec3 out(v.X(), v.Y(), v.Z());
  if (!out.allFinite()) fail(element, "not a finite number; give three finite numbers");
  return out;
}

Pose SceneReader::pose(const ignition::math::Pose3d& p, const std::string& element) const {
  Pose out;
  out.position = vector(p.Pos(), element);
  out.orientation = Eigen::Quaterniond(p.Rot().W(), p.Rot().X(), p.Rot().Y(), p.Rot().Z());
  if (!out.orientation.coeffs().allFinite() || out.orientation.norm() < 0.5)
    fail(element, "not a finite rotation; give six finite numbers");
  out.orientation.normalize();
  return out;
}

Pose SceneReader::resolved(const sdf::SemanticPose& semantic, const std::string& frame,
                           const std::string& element) const {
  ignition::math::Pose3d p;
  check(semantic.Resolve(p, frame), element + " <pose>");
  return pose(p, element + " <pose>");
}

double SceneReader::positive(double value, const std::string& element) const {
  if (!std::isfinite(value) || value <= 0)
    fail(element,
         "must be a positive finite number, is " + std::to_string(value) + "; give one above 0");
  return value;
}

void SceneReader::load(sdf::Root& root) {
  RobotText robot{sceneText(file_), {}};
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
  const auto errors = [&] {
    const SilencedErrors silence;
    try {
      if (!massless_.empty()) return root.LoadSdfString(robot.text, config);
      // libsdformat resolves relative paths by $PWD, which may differ from the working directory.
      return root.Load(std::filesystem::absolute(file_).string(), config);
    } catch (const std::exception& why) {  // a version that is no number
      throw BadInput(file_.string() + ": " + invalid + ": " + why.what());
    }
  }();
  check(errors, invalid);
  if (isRobot() && !root.Model()) fail("<robot>", "has no link with a mass; add one");
  if (!isRobot() && root.WorldCount() != 1)
    fail("<sdf>", "has " + std::to_string(root.WorldCount()) +
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
  scene_.gravity = vector(world.Gravity(), "<gravity>");
  if (const auto* physics = world.PhysicsDefault())
    scene_.step = positive(physics->MaxStepSize(), "<physics> <max_step_size>");
  for (std::uint64_t i = 0; i < world.ModelCount(); ++i)
    readModel(*world.ModelByIndex(i), "", Pose(), false);
  if (scene_.bodies.empty()) fail("<world>", "has no model with a link; add one");
  if (element && element->HasElement("state")) readState(element->GetElement("state"));
}

void SceneReader::readModel(const sdf::Model& model, const std::string& scope, const Pose& parent,
                            bool parentStatic) {
  const std::string name = scope + model.Name();
  const Pose modelPose = parent * resolved(model.SemanticPose(), "", "model '" + name + "'");
  const bool isStatic = parentStatic || model.Static();
  for (std::uint64_t i = 0; i < model.LinkCount(); ++i)
    readLink(model, *model.LinkByIndex(i), name, modelPose, isStatic);
  for (std::uint64_t i = 0; i < model.ModelCount(); ++i)
    readModel(*model.ModelByIndex(i), name + "::", modelPose, isStatic);
  for (std::uint64_t i = 0; i < model.JointCount(); ++i)
    readJoint(*model.JointByIndex(i), name, modelPose);
}

void SceneReader::readLink(const sdf::Model& model, const sdf::Link& link, const std::string& scope,
                           const Pose& modelPose, bool isStatic) {
  SceneBody body;
  const std::string full = scope + "::" + link.Name();
  const std::string element = "link '" + full + "'";
  const Pose linkInModel = resolved(link.SemanticPose(), "", element);
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
  checkCutting(body);
  checkSoft(body);
  if (body.inertialPose)
    body.inertialPose = linkInBody * *body.inertialPose;
  else if (body.inertia)
    body.inertialPose = linkInBody;
  for (SceneCollision& collision : body.collisions) collision.pose = linkInBody * collision.pose;
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
    body.mass = positive(value.MassMatrix().Mass(), name + " <mass>");
  if (inertial->HasElement("pose")) body.inertialPose = pose(value.Pose(), name + " <pose>");
  if (!inertial->HasElement("inertia")) return;
  const auto moi = value.MassMatrix().Moi();
  Eigen::Matrix3d inertia;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) inertia(r, c) = moi(r, c);
  if (!inertia.allFinite()) fail(name + " <inertia>", "not finite; give finite numbers");
  if (!body.mass) fail(name, "gives <inertia> without <mass>; add the mass");
  body.inertia = inertia;
}

void SceneReader::readCollision(const sdf::Collision& collision, SceneBody& body) const {
  SceneCollision out;
  const std::string element = "body '" + body.name + "' collision '" + collision.Name() + "'";
  out.name = collision.Name();
  out.where = file_.string() + ": " + element;
  // In the frame of its link.
  out.pose = resolved(collision.SemanticPose(), "", element);
  if (!collision.Geom()) fail(element, "has no <geometry>; add one");
  out.geometry = readGeometry(*collision.Geom(), element);
  if (std::holds_alternative<ScenePlane>(out.geometry) && body.isFree())
    fail(element, "a <plane> has no mass: make its model <static>true</static>");
  const auto sdfElement = collision.Element();
  if (sdfElement) readOwnElements(out.where, sdfElement, out);
  if (sdfElement && sdfElement->HasElement("surface"))
    readSurface(sdfElement->GetElement("surface"), element, body);
  body.collisions.push_back(std::move(out));
}

void SceneReader::readDrive(const sdf::Link& link, const Pose& linkInBody, SceneBody& body) const {
  const std::string element = "link '" + body.name + "'";
  if (!link.Element()) return;
  body.drive = program::readDrive(file_.string() + ": " + element, link.Element(), linkInBody);
  if (body.drive && body.isStatic)
    fail(element + " <cloudcontact:drive>",
         "a static model does not move; leave <static> or the drive out");
}

// What is cut is one cloud with a mass, which its matter decides.
void SceneReader::checkCutting(const SceneBody& body) const {
  for (const SceneCollision& collision : body.collisions) {
    const bool isPlane = std::holds_alternative<ScenePlane>(collision.geometry);
    const std::string element = "body '" + body.name + "' collision '" + collision.name + "' ";
    if (isPlane && (collision.cutter || collision.isCuttable || !collision.tissues.empty()))
      fail(element, "a <plane> has no voxels to cut or to be of a tissue; use a <box>");
    if (!collision.isCuttable) continue;
    const std::string name = element + "<cloudcontact:cuttable>";
    if (body.collisions.size() > 1)
      fail(name, "the link has other collisions; give a body that is cut one collision");
    if (body.drive) fail(name, "the link has a drive; cut what is free or <static>");
    if (body.inertia || body.inertialPose)
      fail(name, "its <inertial> follows from its matter; give a <mass> alone, or nothing");
  }
}

// Soft tissue has the shape, the mass and the frame of its matter.
void SceneReader::checkSoft(const SceneBody& body) const {
  for (const SceneCollision& collision : body.collisions) {
    if (!collision.soft) continue;
    const std::string name =
        "body '" + body.name + "' collision '" + collision.name + "' <cloudcontact:soft>";
    if (std::holds_alternative<ScenePlane>(collision.geometry))
      fail(name, "a <plane> has no matter; use a <box>");
    if (body.collisions.size() > 1)
      fail(name, "the link has other collisions; give a body that deforms one collision");
    if (!body.isFree())
      fail(name, "the model is <static> or has a drive; hold its sides by the attribute held");
    if (body.inertia || body.inertialPose)
      fail(name, "its <inertial> follows from its matter; give a <mass> alone, or nothing");
    if (body.stiffness) fail(name, "its <kp> follows from its tissues; leave it out");
    if (collision.paper.isGiven())
      fail(name, "only what does not deform has windows and areas; leave them out");
    if (collision.tissues.empty())
      fail(name, "its tissue is missing, whose elasticity it has; add a <cloudcontact:tissue>");
  }
}

// The element at the end of a path of names, or null. GetElement alone creates missing elements.
sdf::ElementPtr descend(sdf::ElementPtr element, std::initializer_list<const char*> path) {
  for (const char* name : path) {
    if (!element || !element->HasElement(name)) return nullptr;
    element = element->GetElement(name);
  }
  return element;
}

void SceneReader::readSurface(const sdf::ElementPtr& surface, const std::string& element,
                              SceneBody& body) const {
  const auto take = [&](std::initializer_list<const char*> path, std::optional<double>& field) {
    const auto found = descend(surface, path);
    if (!found) return;
    const std::string name = element + " <" + *(path.end() - 1) + ">";
    const double value = found->Get<double>();
    if (!std::isfinite(value) || value < 0)
      fail(name, "must be a finite number of 0 or more, is " + std::to_string(value));
    if (field && *field != value)
      fail(name, "differs from the body's other collisions; a body has one surface here");
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
    fail(element + " <restitution_coefficient>",
         "must be at most 1, is " + std::to_string(*body.restitution));
  if (body.stiffness && *body.stiffness == 0)
    fail(element + " <kp>", "is 0: the contact would have no force; give a stiffness in N/m");
}

SceneGeometry SceneReader::readGeometry(const sdf::Geometry& geometry,
                                        const std::string& element) const {
  switch (geometry.Type()) {
    case sdf::GeometryType::BOX: {
      const Vec3 size = vector(geometry.BoxShape()->Size(), element + " <box> <size>");
      positive(size.minCoeff(), element + " <box> <size>");
      return SceneBox{size};
    }
    case sdf::GeometryType::SPHERE:
      return SceneSphere{
          positive(geometry.SphereShape()->Radius(), element + " <sphere> <radius>")};
    case sdf::GeometryType::CYLINDER: {
      const auto* shape = geometry.CylinderShape();
      return SceneCylinder{positive(shape->Radius(), element + " <cylinder> <radius>"),
                           positive(shape->Length(), element + " <cylinder> <length>")};
    }
    case sdf::GeometryType::CAPSULE: {
      const auto* shape = geometry.CapsuleShape();
      return SceneCapsule{positive(shape->Radius(), element + " <capsule> <radius>"),
                          positive(shape->Length(), element + " <capsule> <length>")};
    }
    case sdf::GeometryType::PLANE: {
      const Vec3 normal = vector(geometry.PlaneShape()->Normal(), element + " <plane> <normal>");
      positive(normal.norm(), element + " <plane> <normal>");
      return ScenePlane{normal.normalized()};
    }
    case sdf::GeometryType::MESH:
      return readMesh(*geometry.MeshShape(), element + " <mesh>");
    default:
      fail(element + " <geometry>",
           "is of a kind not known here; use box, sphere, cylinder, capsule, plane or mesh");
  }
}

SceneMesh SceneReader::readMesh(const sdf::Mesh& mesh, const std::string& element) const {
  const std::string uri = pathOf(mesh.Uri(), file_.parent_path());
  if (uri.empty()) fail(element + " <uri>", "is empty; name a mesh file");
  if (uri.find("://") != std::string::npos)
    fail(element + " <uri>", "'" + uri + "' is no path; give one relative to the scene file");
  if (!mesh.Submesh().empty())
    fail(element + " <submesh>", "is not known here; put the part in a file of its own");
  SceneMesh out;
  out.file = (file_.parent_path() / uri).lexically_normal();
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(out.file, ignored))
    fail(element + " <uri>",
         "no file '" + out.file.string() + "'; paths are relative to the scene");
  out.scale = vector(mesh.Scale(), element + " <scale>");
  positive(out.scale.minCoeff(), element + " <scale>");
  return out;
}

int SceneReader::bodyIndex(const std::string& link, const std::string& scope,
                           const std::string& element) const {
  if (link == "world") return -1;
  const auto found = links_.find(scope + "::" + link);
  if (found == links_.end()) fail(element, "no link '" + link + "' in model '" + scope + "'");
  return found->second.body;
}

void SceneReader::readJoint(const sdf::Joint& joint, const std::string& scope,
                            const Pose& modelPose) {
  SceneJoint out;
  out.name = scope + "::" + joint.Name();
  const std::string element = "joint '" + out.name + "'";
  if (joint.Type() == sdf::JointType::REVOLUTE)
    out.kind = SceneJoint::Kind::Revolute;
  else if (joint.Type() == sdf::JointType::PRISMATIC)
    out.kind = SceneJoint::Kind::Prismatic;
  else if (joint.Type() != sdf::JointType::FIXED)
    fail(element, "is of a type not known here; use fixed, revolute or prismatic");
  std::string parent, child;
  check(joint.ResolveParentLink(parent), element + " <parent>");
  check(joint.ResolveChildLink(child), element + " <child>");
  out.parent = bodyIndex(parent, scope, element + " <parent>");
  out.child = bodyIndex(child, scope, element + " <child>");
  out.pose = modelPose * resolved(joint.SemanticPose(), "__model__", element);
  if (const auto* axis = joint.Axis(0); axis && out.kind != SceneJoint::Kind::Fixed) {
    ignition::math::Vector3d xyz;
    check(axis->ResolveXyz(xyz, "__model__"), element + " <axis>");
    const Vec3 local = vector(xyz, element + " <axis> <xyz>");
    positive(local.norm(), element + " <axis> <xyz>");
    out.axis = (modelPose.orientation * local).normalized();
    const auto limit = descend(axis->Element(), {"limit"});
    if (descend(limit, {"lower"})) out.lower = axis->Lower();
    if (descend(limit, {"upper"})) out.upper = axis->Upper();
    // libsdformat's stand-in for "no limit".
    if (out.lower && *out.lower <= -1e15) out.lower.reset();
    if (out.upper && *out.upper >= 1e15) out.upper.reset();
    readDynamics(*axis, element, out);
  }
  scene_.joints.push_back(std::move(out));
}

// <dynamics>: a spring, its damper and friction.
void SceneReader::readDynamics(const sdf::JointAxis& axis, const std::string& element,
                               SceneJoint& joint) const {
  joint.spring = axis.SpringStiffness();
  joint.damping = axis.Damping();
  joint.rest = axis.SpringReference();
  joint.friction = axis.Friction();
  for (const double value : {joint.spring, joint.damping, joint.friction})
    if (!(value >= 0) || !std::isfinite(value))
      fail(element + " <dynamics>",
           "<spring_stiffness>, <damping> and <friction> must be 0 or more and finite");
  if (!std::isfinite(joint.rest))
    fail(element + " <dynamics>", "<spring_reference> must be finite");
}

// Initial velocities: <state><model name><link name><velocity>, linear then angular.
void SceneReader::readState(const sdf::ElementPtr& state) {
  for (auto model = descend(state, {"model"}); model; model = model->GetNextElement("model")) {
    const std::string modelName = model->Get<std::string>("name");
    for (auto link = descend(model, {"link"}); link; link = link->GetNextElement("link")) {
      const std::string full = modelName + "::" + link->Get<std::string>("name");
      const auto found = links_.find(full);
      if (found == links_.end()) fail("<state>", "no link '" + full + "' in this world");
      const auto velocity = descend(link, {"velocity"});
      if (!velocity) continue;
      const std::string element = "<state> link '" + full + "' <velocity>";
      std::istringstream numbers(velocity->GetValue()->GetAsString());
      Eigen::Matrix<double, 6, 1> v;
      for (int i = 0; i < 6; ++i)
        if (!(numbers >> v[i]) || !std::isfinite(v[i]))
          fail(element, "needs six finite numbers: linear [m/s], then angular [rad/s]");
      SceneBody& body = scene_.bodies[found->second.body];
      if (body.drive) fail(element, "the link has a <cloudcontact:drive>; leave one of them out");
      const Vec3 linear = v.head<3>(), angular = v.tail<3>();
      body.angularVelocity = angular;
      // Given at the link's origin.
      body.linearVelocity = linear - angular.cross(body.pose.orientation * found->second.origin);
    }
  }
}

}  // namespace

SceneDescription loadScene(const std::filesystem::path& file) {
  SceneDescription scene = SceneReader(file).read();
  try {
    validate(scene);
  } catch (const BadInput& why) {
    throw BadInput(file.string() + ": " + why.what() + "; change it");
  }
  return scene;
}

}  // namespace cloudcontact::program
