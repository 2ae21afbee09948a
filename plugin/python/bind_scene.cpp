// Python: scenes, of files or built by hand.
#include <algorithm>
#include <cmath>
#include <map>

#include "io/errors.h"
#include "python/bindings.h"
#include "python/numpy_views.h"
#include "python/python_words.h"
#include "scene/scene.h"
#include "scene/scene_check.h"
#include "scene/scene_file.h"
#include "scene/scene_text.h"

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
  } else if (py::isinstance<SurfaceField>(shape)) {
    SceneMesh voxels{madeName(scene, body), scale, nullptr};
    voxels.field = shape.cast<std::shared_ptr<SurfaceField>>();
    voxels.cloud = std::make_shared<const Cloud>(voxels.field->cloud());
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
  } else if (py::isinstance<Cone>(shape)) {
    const auto cone = shape.cast<Cone>();
    out.geometry = SceneCone{cone.radius, 2 * cone.halfHeight};
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
          "shape: give a file, a Mesh, a Cloud, a SurfaceField, a Box, Sphere, Cylinder, "
          "Capsule, Cone or HalfSpace");
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

// What add() takes beside the shape.
struct BodyWords {
  std::optional<double> mass, friction, stiffness, damping, restitution;
  bool isStatic = false;
};

void checkWords(const BodyWords& words) {
  if (words.isStatic && words.mass)
    throw std::invalid_argument("mass: a static body does not move; leave one of the two out");
  if (words.damping && !words.stiffness)
    throw std::invalid_argument("damping: needs a stiffness beside it; give both or neither");
}

SceneDrive driveOf(const py::object& drive, bool isStatic) {
  if (isStatic)
    throw std::invalid_argument("drive: a static body does not move; leave one of the two out");
  if (!py::isinstance<py::sequence>(drive) || py::len(drive) != 2)
    throw std::invalid_argument("drive: give two velocities, (linear, angular)");
  const py::object linear = drive[py::int_(0)], angular = drive[py::int_(1)];
  return {Pose(), vectorOf("drive, linear", linear), vectorOf("drive, angular", angular)};
}

// How its contacts are found, where they are not as usual.
struct ContactWords {
  py::object window, representative, area;
  std::optional<double> tolerance;
};

// As in files.
Solid plainSolidOf(const char* what, const py::object& value) {
  if (py::isinstance<Sphere>(value) || py::isinstance<Box>(value) ||
      py::isinstance<Ellipsoid>(value))
    return solidOf(what, value);
  throw std::invalid_argument(std::string(what) + ": give a Sphere, Box or Ellipsoid");
}

void takeContact(const ContactWords& words, SceneCollision& collision) {
  const bool any = !words.window.is_none() || !words.representative.is_none() ||
                   !words.area.is_none() || words.tolerance;
  if (any && std::holds_alternative<ScenePlane>(collision.geometry))
    throw std::invalid_argument(
        "shape: a half-space has no voxels, and so no window, representative, area or tolerance");
  if (!words.window.is_none()) collision.paper.window = plainSolidOf("window", words.window);
  if (!words.representative.is_none())
    collision.paper.representative = vectorOf("representative", words.representative);
  if (!words.area.is_none()) collision.paper.area = plainSolidOf("area", words.area);
  if (words.tolerance && !(*words.tolerance >= 0 && std::isfinite(*words.tolerance)))
    throw std::invalid_argument("tolerance: must be 0 or more and finite");
  collision.tolerance = words.tolerance;
}

// It deforms.
struct SoftWords {
  std::optional<double> spacing;
  std::string held;
};

void takeSoft(const SoftWords& words, const SceneBody& body, SceneCollision& collision) {
  if (!words.spacing) {
    if (!words.held.empty())
      throw std::invalid_argument("held: of a body that deforms; give soft, too");
    return;
  }
  if (!(*words.spacing > 0) || !std::isfinite(*words.spacing))
    throw std::invalid_argument("soft: must be the way between nodes [m], above 0 and finite");
  if (!body.isFree())
    throw std::invalid_argument("soft: the body is static or driven; hold its sides by held");
  if (body.stiffness)
    throw std::invalid_argument("soft: its stiffness follows from its tissue; leave one out");
  if (collision.paper.isGiven())
    throw std::invalid_argument("soft: what deforms has no window, representative and area");
  if (collision.isCuttable || collision.cutter)
    throw std::invalid_argument("soft: soft tissue neither cuts nor wears; leave the other out");
  if (std::holds_alternative<ScenePlane>(collision.geometry))
    throw std::invalid_argument("soft: a half-space has no matter; give a Box");
  if (collision.tissues.empty())
    throw std::invalid_argument("soft: give its tissue, whose elasticity it has");
  collision.soft = SceneSoft{*words.spacing, sidesOf("held", words.held)};
}

void addBody(SceneDescription& scene, const std::string& name, const py::object& shape,
             const py::object& pose, const BodyWords& words, const py::object& velocity,
             const py::object& angularVelocity, const py::object& unit, const py::object& tissue,
             bool cuttable, const std::optional<Cutter>& cutter, double ability,
             const py::object& drive, const ContactWords& contact, const SoftWords& soft) {
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
  if (!velocity.is_none()) body.linearVelocity = vectorOf("velocity", velocity);
  if (!angularVelocity.is_none())
    body.angularVelocity = vectorOf("angular_velocity", angularVelocity);
  if (words.isStatic && !(body.linearVelocity.isZero(0) && body.angularVelocity.isZero(0)))
    throw std::invalid_argument("velocity: a static body does not move; leave one of the two out");
  body.model = static_cast<int>(scene.bodies.size());
  SceneCollision collision = collisionOf(scene, name, shape, Vec3::Constant(unitOf(unit)));
  collision.tissues = tissuesOf(tissue);
  collision.isCuttable = cuttable;
  if (cutter) collision.cutter = SceneCutter{ability, *cutter};
  if (std::holds_alternative<ScenePlane>(collision.geometry) && !words.isStatic)
    throw std::invalid_argument("shape: a half-space has no mass; give static=True");
  if (!drive.is_none()) body.drive = driveOf(drive, words.isStatic);
  takeContact(contact, collision);
  takeSoft(soft, body, collision);
  body.collisions.push_back(std::move(collision));
  validate(body);
  scene.bodies.push_back(std::move(body));
}

// What join() takes of an axis.
struct AxisWords {
  std::optional<double> lower, upper;
  double spring = 0, damping = 0, rest = 0, friction = 0, effort = HUGE_VAL;
};

void takeAxis(const AxisWords& words, SceneAxis& axis) {
  // What is without end is no limit.
  if (words.lower && *words.lower > -HUGE_VAL) axis.lower = words.lower;
  if (words.upper && *words.upper < HUGE_VAL) axis.upper = words.upper;
  axis.spring = words.spring;
  axis.damping = words.damping;
  axis.rest = words.rest;
  axis.friction = words.friction;
  axis.effort = words.effort;
}

// A direction, or a dict with `axis` and an axis' further words.
SceneAxis secondAxis(const py::object& second) {
  SceneAxis axis;
  if (!py::isinstance<py::dict>(second)) {
    axis.axis = vectorOf("second", second);
    return axis;
  }
  AxisWords words;
  bool points = false;
  const std::map<std::string, double*> numbers = {{"spring", &words.spring},
                                                  {"damping", &words.damping},
                                                  {"rest", &words.rest},
                                                  {"friction", &words.friction},
                                                  {"effort", &words.effort}};
  for (const auto& [key, value] : second.cast<py::dict>()) {
    const auto word = key.cast<std::string>();
    const py::object given = py::reinterpret_borrow<py::object>(value);
    if (word == "axis")
      axis.axis = vectorOf("second", given), points = true;
    else if (word == "lower" || word == "upper")
      (word == "lower" ? words.lower : words.upper) =
          given.is_none() ? std::optional<double>() : numberOf(word.c_str(), given);
    else if (const auto at = numbers.find(word); at != numbers.end())
      *at->second = numberOf(word.c_str(), given);
    else
      throw std::invalid_argument("second: has no '" + word + "'");
  }
  if (!points) throw std::invalid_argument("second: give its 'axis'");
  takeAxis(words, axis);
  return axis;
}

// Joints are known by their names. One without takes that of its bodies.
std::string jointName(const SceneDescription& scene, const std::optional<std::string>& name,
                      const std::string& child, const std::optional<std::string>& parent) {
  const std::string own = name.value_or(child + " to " + parent.value_or("the world"));
  for (const SceneJoint& other : scene.joints)
    if (other.name == own)
      throw std::invalid_argument("scene '" + scene.name + "': has a joint '" + own + "'; give " +
                                  (name ? "another" : "this one a") + " name");
  return own;
}

void addJoint(SceneDescription& scene, const std::string& kind, const std::string& child,
              const std::optional<std::string>& parent, const py::object& position,
              const py::object& axis, const std::optional<std::string>& name,
              std::optional<double> lower, std::optional<double> upper, double spring,
              double damping, double rest, double friction, double effort, double pitch,
              const py::object& second) {
  SceneJoint joint;
  joint.kind = jointKind(kind);
  joint.child = bodyNumber(scene, child);
  if (parent) joint.parent = bodyNumber(scene, *parent);
  joint.name = jointName(scene, name, child, parent);
  if (!position.is_none()) joint.pose.position = vectorOf("position", position);
  if (!axis.is_none()) joint.axis = vectorOf("axis", axis);
  takeAxis({lower, upper, spring, damping, rest, friction, effort}, joint);
  joint.pitch = pitch;
  const auto only = [&](bool given, const char* words, bool fits, const char* which) {
    if (given && !fits)
      throw std::invalid_argument("joint '" + joint.name + "': " + words + " belong to " + which +
                                  " joints; leave them out");
  };
  const bool drives = spring != 0 || damping != 0 || friction != 0 || !std::isinf(effort);
  only(lower || upper || drives, "limits, spring, damping, friction and effort", joint.axes() > 0,
       "moving");
  only(pitch != 0, "pitches", joint.kind == SceneJoint::Kind::Screw, "screw");
  only(!second.is_none(), "second axes", joint.axes() == 2, "universal");
  if (joint.axes() == 2) {
    if (second.is_none())
      throw std::invalid_argument("joint '" + joint.name + "': give its second axis");
    joint.second = secondAxis(second);
  }
  validate(joint);
  joint.axis.normalize();
  joint.second.axis.normalize();
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
          "_add",
          [](SceneDescription& scene, const std::string& name, const py::object& shape,
             const py::object& pose, std::optional<double> mass, bool isStatic,
             std::optional<double> friction, std::optional<double> stiffness,
             std::optional<double> damping, std::optional<double> restitution,
             const py::object& velocity, const py::object& angularVelocity, const py::object& unit,
             const py::object& tissue, bool cuttable, const std::optional<Cutter>& cutter,
             double ability, const py::object& drive, const py::object& window,
             const py::object& representative, const py::object& area,
             std::optional<double> tolerance, std::optional<double> soft, const std::string& held) {
            addBody(scene, name, shape, pose,
                    {mass, friction, stiffness, damping, restitution, isStatic}, velocity,
                    angularVelocity, unit, tissue, cuttable, cutter, ability, drive,
                    {window, representative, area, tolerance}, {soft, held});
          },
          "name"_a, "shape"_a, "pose"_a = py::none(), py::kw_only(), "mass"_a = py::none(),
          "static"_a = false, "friction"_a = py::none(), "stiffness"_a = py::none(),
          "damping"_a = py::none(), "restitution"_a = py::none(), "velocity"_a = py::none(),
          "angular_velocity"_a = py::none(), "unit"_a = 1.0, "tissue"_a = py::none(),
          "cuttable"_a = false, "cutter"_a = py::none(), "ability"_a = 1.0, "drive"_a = py::none(),
          "window"_a = py::none(), "representative"_a = py::none(), "area"_a = py::none(),
          "tolerance"_a = py::none(), "soft"_a = py::none(), "held"_a = "")
      .def("add",
           takingWords("add", {"name",
                               "shape",
                               "pose",
                               "mass",
                               "static",
                               "friction",
                               "stiffness",
                               "damping",
                               "restitution",
                               "velocity",
                               "angular_velocity",
                               "unit",
                               "tissue",
                               "cuttable",
                               "cutter",
                               "ability",
                               "drive",
                               "window",
                               "representative",
                               "area",
                               "tolerance",
                               "soft",
                               "held"}),
           "Adds a body.\n\n"
           "shape: a file of a mesh, points, a CT volume or a cloud, a Mesh, a Cloud, or a Box,\n"
           "Sphere, Cylinder, Capsule, Cone or HalfSpace. pose: of its frame in the world. mass\n"
           "[kg]; none: at the density of its tissues, or of water. static: it does not move. A\n"
           "Box, Sphere, Cylinder, Capsule or Cone without a tissue meets its like as that exact\n"
           "shape, and a static one all others, too; give a Mesh or Cloud of it for voxels.\n"
           "friction: of a pair the smaller counts. stiffness [N/m], damping [N s/m]: of its\n"
           "contacts, in series with the other body's; none: as hard as the step allows.\n"
           "restitution: 0 to 1; of a pair the product counts, where one of them states it.\n"
           "velocity: of the frame's origin (3,) [m/s].\n"
           "angular_velocity (3,) [rad/s]. unit: of a mesh, meters or \"mm\" .... tissue: a name\n"
           "in World's table, or a dict of names by the mesh's parts. cuttable: tools cut it.\n"
           "cutter: it is a tool, with its cutting `ability`. drive: velocities (linear, angular)\n"
           "that nothing changes. window, representative (3,), area: the paper's C, Gr from C's\n"
           "center, and D, a Sphere, Box or Ellipsoid [m]. tolerance: of its contacts [m]; 0: it\n"
           "is never taken for a plain shape. soft: it deforms by its tissue's elasticity, with\n"
           "this way between its nodes [m]; held: the sides whose nodes stay, as \"-z\" or\n"
           "\"-x +x\". Raises ValueError that names what does not fit.")
      .def("_join", &addJoint, "kind"_a, "child"_a, "parent"_a = py::none(),
           "position"_a = py::none(), "axis"_a = py::none(), py::kw_only(), "name"_a = py::none(),
           "lower"_a = py::none(), "upper"_a = py::none(), "spring"_a = 0.0, "damping"_a = 0.0,
           "rest"_a = 0.0, "friction"_a = 0.0, "effort"_a = HUGE_VAL, "pitch"_a = 0.0,
           "second"_a = py::none())
      .def("join",
           takingWords("join",
                       {"kind", "child", "parent", "position", "axis", "name", "lower", "upper",
                        "spring", "damping", "rest", "friction", "effort", "pitch", "second"}),
           "Adds a joint between two bodies, or a body and the world.\n\n"
           "kind: \"fixed\", \"revolute\", \"prismatic\", \"screw\", \"ball\" or \"universal\".\n"
           "position (3,) [m], none: the origin, and axis (3,), none: z: in the world, at the\n"
           "start. name: of World.joint(); none: \"CHILD to PARENT\". lower, upper: limits\n"
           "[rad, m]. spring, damping, rest: it is pulled to `rest` and slowed down [N m/rad,\n"
           "N m s/rad, rad; N/m, N s/m, m]. friction: holds it still up to this torque or force\n"
           "[N m, N]. effort: the most that a Motor pushes [N m, N]. pitch: of a screw, its way\n"
           "in a turn [m], above 0 of a right-handed one. second: of a universal joint the axis\n"
           "that the child holds, across the parent's: (3,), or a dict of `axis`, `lower`,\n"
           "`upper`, `spring`, `damping`, `rest`, `friction`, `effort`.")
      .def_readwrite("name", &SceneDescription::name)
      .def_property(
          "step", [](const SceneDescription& s) { return s.step; },
          [](SceneDescription& s, const py::object& step) {
            const double seconds = numberOf("step", step);
            if (!(seconds > 0) || !std::isfinite(seconds))
              throw std::invalid_argument("step: must be above 0 and finite");
            s.step = seconds;
          },
          "Of the world's time [s].")
      .def_property(
          "gravity", [](const SceneDescription& s) { return s.gravity; },
          [](SceneDescription& s, const py::object& g) { s.gravity = vectorOf("gravity", g); },
          "(3,) [m/s^2]")
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
