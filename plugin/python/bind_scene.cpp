// Python: scenes, of files or built by hand.
#include <algorithm>

#include "io/errors.h"
#include "python/bindings.h"
#include "python/numpy_views.h"
#include "scene/scene.h"
#include "scene/scene_file.h"

namespace cloudcontact::python {
namespace {

using namespace py::literals;
using namespace program;

// A name that no other mesh or cloud made in memory has.
std::string madeName(const SceneDescription& scene, const std::string& body) {
  return body + " (" + std::to_string(scene.bodies.size()) + ")";
}

// Of a body's shape, and its place in the body: that of a half-space with an offset.
SceneCollision collisionOf(const SceneDescription& scene, const std::string& body,
                           const py::object& shape, const Vec3& scale) {
  SceneCollision out;
  out.name = body;
  out.where = scene.name + ": body '" + body + "'";
  if (py::isinstance<Mesh>(shape)) {
    const auto mesh = std::make_shared<const Mesh>(shape.cast<const Mesh&>());
    out.geometry = SceneMesh{madeName(scene, body), scale, mesh};
  } else if (py::isinstance<Cloud>(shape)) {
    SceneMesh voxels{madeName(scene, body), scale, nullptr};
    voxels.cloud = std::make_shared<const Cloud>(shape.cast<const Cloud&>());
    out.geometry = std::move(voxels);
  } else if (py::isinstance<Box>(shape)) {
    out.geometry = SceneBox{2 * shape.cast<Box>().halfExtents};
  } else if (py::isinstance<Sphere>(shape)) {
    out.geometry = SceneSphere{shape.cast<Sphere>().radius};
  } else if (py::isinstance<Cylinder>(shape)) {
    const auto cylinder = shape.cast<Cylinder>();
    out.geometry = SceneCylinder{cylinder.radius, 2 * cylinder.halfHeight};
  } else if (py::isinstance<Capsule>(shape)) {
    const auto capsule = shape.cast<Capsule>();
    out.geometry = SceneCapsule{capsule.radius, 2 * capsule.halfHeight};
  } else if (py::isinstance<HalfSpace>(shape)) {
    const auto half = shape.cast<HalfSpace>();
    out.geometry = ScenePlane{half.normal};
    out.pose.position = half.offset * half.normal;
  } else {
    std::filesystem::path file;
    try {
      file = shape.cast<std::filesystem::path>();
    } catch (const py::cast_error&) {
      throw std::invalid_argument(
          "shape: give a file, a Mesh, a Cloud, a Box, Sphere, Cylinder, "
          "Capsule or HalfSpace");
    }
    if (!std::filesystem::is_regular_file(file))
      throw std::invalid_argument("shape: no file '" + file.string() + "'");
    out.geometry = SceneMesh{file, scale, nullptr};
  }
  return out;
}

// A tissue for all parts, or a dict of tissues by part.
std::vector<SceneTissue> tissuesOf(const py::object& tissue) {
  if (tissue.is_none()) return {};
  if (py::isinstance<py::str>(tissue)) return {{"", tissue.cast<std::string>()}};
  std::vector<SceneTissue> tissues;
  for (const auto& [part, name] : tissue.cast<py::dict>())
    tissues.push_back({part.cast<std::string>(), name.cast<std::string>()});
  return tissues;
}

int bodyNumber(const SceneDescription& scene, const std::string& name) {
  const auto at = std::find_if(scene.bodies.begin(), scene.bodies.end(),
                               [&](const SceneBody& b) { return b.name == name; });
  if (at == scene.bodies.end())
    throw std::invalid_argument("scene '" + scene.name + "': no body '" + name + "'; add it first");
  return static_cast<int>(at - scene.bodies.begin());
}

void atLeast(const char* what, const std::optional<double>& value, double least) {
  if (value && !(*value >= least && std::isfinite(*value)))
    throw std::invalid_argument(std::string(what) + ": must be a finite number of " +
                                (least > 0 ? "more than 0" : "0 or more"));
}

// What add() takes beside the shape.
struct BodyWords {
  std::optional<double> mass, friction, stiffness, damping, restitution;
  bool isStatic = false;
};

void checkWords(const BodyWords& words) {
  constexpr double kAboveZero = 1e-300;
  atLeast("mass", words.mass, kAboveZero);
  atLeast("friction", words.friction, 0);
  atLeast("stiffness", words.stiffness, kAboveZero);
  atLeast("damping", words.damping, 0);
  atLeast("restitution", words.restitution, 0);
  if (words.isStatic && words.mass)
    throw std::invalid_argument("mass: a static body does not move; leave one of the two out");
}

void addBody(SceneDescription& scene, const std::string& name, const py::object& shape,
             const py::object& pose, const BodyWords& words, const Vec3& velocity,
             const Vec3& angularVelocity, const py::object& unit, const py::object& tissue,
             bool cuttable, const std::optional<Cutter>& cutter, double ability,
             const py::object& drive) {
  checkWords(words);
  if (std::any_of(scene.bodies.begin(), scene.bodies.end(),
                  [&](const SceneBody& b) { return b.name == name; }))
    throw std::invalid_argument("scene '" + scene.name + "': has a body '" + name +
                                "'; give another name");
  SceneBody body;
  body.name = name;
  body.pose = poseOf("pose", pose);
  body.isStatic = words.isStatic;
  body.mass = words.mass;
  body.friction = words.friction;
  body.stiffness = words.stiffness;
  body.damping = words.damping;
  body.restitution = words.restitution;
  body.linearVelocity = velocity;
  body.angularVelocity = angularVelocity;
  body.model = static_cast<int>(scene.bodies.size());
  SceneCollision collision = collisionOf(scene, name, shape, Vec3::Constant(unitOf(unit)));
  collision.tissues = tissuesOf(tissue);
  collision.isCuttable = cuttable;
  if (cutter) collision.cutter = SceneCutter{ability, *cutter};
  if (std::holds_alternative<ScenePlane>(collision.geometry) && !words.isStatic)
    throw std::invalid_argument("shape: a half-space has no mass; give static=True");
  if (!drive.is_none()) {
    const auto [linear, angular] = drive.cast<std::pair<Vec3, Vec3>>();
    if (words.isStatic)
      throw std::invalid_argument("drive: a static body does not move; leave one of the two out");
    body.drive = SceneDrive{Pose(), linear, angular};
  }
  body.collisions.push_back(std::move(collision));
  scene.bodies.push_back(std::move(body));
}

SceneJoint::Kind kindOf(const std::string& kind) {
  if (kind == "fixed") return SceneJoint::Kind::Fixed;
  if (kind == "revolute") return SceneJoint::Kind::Revolute;
  if (kind == "prismatic") return SceneJoint::Kind::Prismatic;
  throw std::invalid_argument("kind: '" + kind +
                              "' is not known; give fixed, revolute or prismatic");
}

void addJoint(SceneDescription& scene, const std::string& kind, const std::string& child,
              const std::optional<std::string>& parent, const Vec3& position, const Vec3& axis,
              std::optional<double> lower, std::optional<double> upper, double spring,
              double damping, double rest) {
  SceneJoint joint;
  joint.kind = kindOf(kind);
  joint.child = bodyNumber(scene, child);
  if (parent) joint.parent = bodyNumber(scene, *parent);
  joint.name = child + " to " + parent.value_or("the world");
  if (!position.allFinite() || !axis.allFinite() || axis.norm() < 1e-12)
    throw std::invalid_argument("joint '" + joint.name +
                                "': position and axis must be finite, and the axis not 0");
  joint.pose.position = position;
  joint.axis = axis.normalized();
  joint.lower = lower;
  joint.upper = upper;
  if (!(spring >= 0 && damping >= 0))
    throw std::invalid_argument("joint '" + joint.name + "': spring and damping must be 0 or more");
  joint.spring = spring;
  joint.damping = damping;
  joint.rest = rest;
  scene.joints.push_back(std::move(joint));
}

}  // namespace

void bindScene(py::module_& module) {
  py::class_<SceneDescription>(module, "Scene", "Bodies and joints from which a World is made.")
      .def(py::init([](std::string name, const Vec3& gravity, double step) {
             SceneDescription scene;
             scene.name = std::move(name);
             scene.gravity = gravity;
             scene.step = step;
             if (!gravity.allFinite() || !(step > 0) || !std::isfinite(step))
               throw std::invalid_argument("scene: gravity must be finite and step above 0");
             return scene;
           }),
           "name"_a = "scene", "gravity"_a = Vec3(0, 0, -9.81), "step"_a = 1e-3,
           "gravity (3,) [m/s^2]. step: of the world's time [s].")
      .def_static("load", &loadScene, "file"_a,
                  "Reads the only world of an SDFormat file, or the robot of a URDF file. Raises\n"
                  "ValueError that names the file and the element.")
      .def(
          "add",
          [](SceneDescription& scene, const std::string& name, const py::object& shape,
             const py::object& pose, std::optional<double> mass, bool isStatic,
             std::optional<double> friction, std::optional<double> stiffness,
             std::optional<double> damping, std::optional<double> restitution, const Vec3& velocity,
             const Vec3& angularVelocity, const py::object& unit, const py::object& tissue,
             bool cuttable, const std::optional<Cutter>& cutter, double ability,
             const py::object& drive) {
            addBody(scene, name, shape, pose,
                    {mass, friction, stiffness, damping, restitution, isStatic}, velocity,
                    angularVelocity, unit, tissue, cuttable, cutter, ability, drive);
          },
          "name"_a, "shape"_a, "pose"_a = py::none(), py::kw_only(), "mass"_a = py::none(),
          "static"_a = false, "friction"_a = py::none(), "stiffness"_a = py::none(),
          "damping"_a = py::none(), "restitution"_a = py::none(),
          "velocity"_a = Vec3::Zero().eval(), "angular_velocity"_a = Vec3::Zero().eval(),
          "unit"_a = 1.0, "tissue"_a = py::none(), "cuttable"_a = false, "cutter"_a = py::none(),
          "ability"_a = 1.0, "drive"_a = py::none(),
          "Adds a body.\n\n"
          "shape: a file of a mesh, points, a CT volume or a cloud, a Mesh, a Cloud, or a Box,\n"
          "Sphere, Cylinder, Capsule or HalfSpace. pose: of its frame in the world. mass [kg]; "
          "none:\n"
          "at the density of its tissues, or of water. static: it does not move. friction: of a "
          "pair\n"
          "the smaller counts. stiffness [N/m], damping [N s/m]: of its contacts, in series with "
          "the\n"
          "other body's; none: as hard as the step allows. velocity: of the frame's origin (3,)\n"
          "[m/s]. angular_velocity (3,) [rad/s]. unit: of a mesh, meters or \"mm\" .... tissue: a\n"
          "name in World's table, or a dict of names by the mesh's parts. cuttable: tools cut it.\n"
          "cutter: it is a tool, with its cutting `ability`. drive: velocities (linear, angular) "
          "that\n"
          "nothing changes. Raises ValueError that names what does not fit.")
      .def("join", &addJoint, "kind"_a, "child"_a, "parent"_a = py::none(),
           "position"_a = Vec3::Zero().eval(), "axis"_a = Vec3::UnitZ().eval(), py::kw_only(),
           "lower"_a = py::none(), "upper"_a = py::none(), "spring"_a = 0.0, "damping"_a = 0.0,
           "rest"_a = 0.0,
           "Adds a joint between two bodies, or a body and the world.\n\n"
           "kind: \"fixed\", \"revolute\" or \"prismatic\". position (3,) [m] and axis (3,): in "
           "the\n"
           "world, at the start. lower, upper: limits [rad, m]. spring [N/m], damping [N s/m], "
           "rest\n"
           "[m]: of a prismatic joint.")
      .def_readwrite("name", &SceneDescription::name)
      .def_readwrite("step", &SceneDescription::step, "Of the world's time [s].")
      .def_property(
          "gravity", [](const SceneDescription& s) { return s.gravity; },
          [](SceneDescription& s, const Vec3& g) { s.gravity = g; }, "(3,) [m/s^2]")
      .def_property_readonly(
          "bodies",
          [](const SceneDescription& s) {
            std::vector<std::string> names;
            for (const SceneBody& b : s.bodies) names.push_back(b.name);
            return names;
          },
          "Names, in their order.")
      .def_property_readonly(
          "joints",
          [](const SceneDescription& s) {
            std::vector<std::string> names;
            for (const SceneJoint& j : s.joints) names.push_back(j.name);
            return names;
          },
          "Names, in their order.");
}

}  // namespace cloudcontact::python
