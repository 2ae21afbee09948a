// A scene as plain values: what an SDFormat world says, with nothing added. An element that the
// file leaves out is an empty optional here, never the format's own default.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/mesh/mesh.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace cloudcontact::program {

// Geometries, each about its own frame's origin, axes along z. [m]
struct SceneBox {
  Vec3 size = Vec3::Ones();  // full edges
};
struct SceneSphere {
  double radius = 1;
};
struct SceneCylinder {
  double radius = 1, length = 1;
};
struct SceneCapsule {
  double radius = 1, length = 1;  // length of the straight part
};
struct ScenePlane {
  Vec3 normal = Vec3::UnitZ();  // material behind it, endless
};
// A file, or a mesh made in memory (then `file` is only its name, and equal names are one mesh).
struct SceneMesh {
  std::filesystem::path file;
  Vec3 scale = Vec3::Ones();
  std::shared_ptr<const Mesh> mesh;
};
using SceneGeometry =
    std::variant<SceneBox, SceneSphere, SceneCylinder, SceneCapsule, ScenePlane, SceneMesh>;

struct SceneCollision {
  std::string name;
  Pose pose;  // in the body's frame
  SceneGeometry geometry;
};

// A link of a model. Where the model has one link the body has the model's name and frame, else
// MODEL::LINK and the link's frame.
struct SceneBody {
  std::string name;
  Pose pose;  // of the body's frame in the world
  bool isStatic = false;
  std::optional<double> mass;              // [kg]
  std::optional<Pose> inertialPose;        // centre of mass and axes, in the body's frame
  std::optional<Eigen::Matrix3d> inertia;  // about the centre of mass, in inertialPose's axes
  std::vector<SceneCollision> collisions;
  // The surface, one for all collisions of a body: Bullet rubs and presses by body.
  std::optional<double> friction;       // mu
  std::optional<double> stiffness;      // kp [N/m]
  std::optional<double> damping;        // kd [N s/m]
  Vec3 linearVelocity = Vec3::Zero();   // of the frame's origin, in the world [m/s]
  Vec3 angularVelocity = Vec3::Zero();  // in the world [rad/s]
  int model = 0;                        // bodies of one model do not touch each other ...
  bool selfCollide = false;             // ... unless the model says so
};

struct SceneJoint {
  enum class Kind { Fixed, Revolute };
  std::string name;
  Kind kind = Kind::Fixed;
  int parent = -1, child = -1;  // index into bodies, -1: the world
  Pose pose;                    // of the joint's frame in the world, at the start
  Vec3 axis = Vec3::UnitZ();    // in the world, at the start
  std::optional<double> lower;  // [rad]
  std::optional<double> upper;
};

struct SceneDescription {
  std::string name;
  Vec3 gravity{0, 0, -9.8};  // the format's own [m/s^2]
  double step = 1e-3;        // the format's own [s]
  std::vector<SceneBody> bodies;
  std::vector<SceneJoint> joints;
};

// Reads the one world of an SDFormat file; mesh paths are relative to it. Throws BadInput naming
// the file and the element: unreadable, not SDFormat, no world, a geometry or joint not known
// here, a value that is not finite or not positive where it must be.
SceneDescription loadScene(const std::filesystem::path& file);

}  // namespace cloudcontact::program
