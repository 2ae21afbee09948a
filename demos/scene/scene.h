// A scene as plain values, as an SDFormat world states them (scene_file.h). An element that the
// file leaves out is an empty optional, never the format's default.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/law/solid.h>
#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/voxels/ct_volume.h>
#include <cloudcontact/workpiece/cutter.h>

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "scene/scene_joint.h"

namespace cloudcontact::program {

// Geometries, centered at the origin of their frame, axes along z. [m]
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
struct SceneCone {
  double radius = 1, length = 1;  // base at -length / 2, tip at +length / 2
};
struct ScenePlane {
  Vec3 normal = Vec3::UnitZ();  // infinite; the material lies behind it
};
// A mesh from a file, or a mesh or voxels made in memory: then `file` is their name, and equal
// names mean equal meshes. A file may also hold points, a CT volume or another digital object.
struct SceneMesh {
  std::filesystem::path file;
  Vec3 scale = Vec3::Ones();
  std::shared_ptr<const Mesh> mesh;
  std::shared_ptr<const Cloud> cloud = {};
  std::shared_ptr<const SurfaceField> field = {};  // of the cloud, if it is made already
  std::vector<CtRange> thresholds = {};            // of a volume; empty: those of --threshold
};
using SceneGeometry = std::variant<SceneBox, SceneSphere, SceneCylinder, SceneCapsule, SceneCone,
                                   ScenePlane, SceneMesh>;

// What a part is made of, by the name of a tissue.
struct SceneTissue {
  std::string part;  // of the mesh file; empty: all that no other entry names
  std::string name;
};

// A collision that cuts: its ability in (5') and the cutter.
struct SceneCutter {
  double ability = 1;
  Cutter cutter;
};

// A collision that deforms.
struct SceneSoft {
  double spacing = 0;             // of its nodes [m]
  std::array<bool, 6> held = {};  // the sides -x +x -y +y -z +z whose nodes stay in their places
};

// What a collision brings to contacts by the paper's method; empty: the default. [m]
struct ScenePaper {
  std::optional<Solid> window;         // C, in the collision's axes
  std::optional<Vec3> representative;  // Gr from C's center, in the collision's axes
  std::optional<Solid> area;           // D, in the collision's frame
  bool isGiven() const { return window || representative || area; }
};

struct SceneCollision {
  std::string name;
  Pose pose;  // in the body's frame
  SceneGeometry geometry;
  std::string where = {};  // for messages: the file and the collision
  std::vector<SceneTissue> tissues = {};
  std::optional<SceneCutter> cutter = {};
  bool isCuttable = false;
  std::optional<SceneSoft> soft = {};
  ScenePaper paper = {};
  // Fidelity::tolerance [m]; empty: the command line's; 0: always as voxels.
  std::optional<double> tolerance = {};
};

// A body that moves at constant velocity, whatever it meets.
struct SceneDrive {
  Pose place;                   // of the driven frame in the body's frame
  Vec3 linear = Vec3::Zero();   // of the driven frame's origin, in the world [m/s]
  Vec3 angular = Vec3::Zero();  // about it, in the world [rad/s]
};

// A link of a model. The only link of a model has the model's name and frame; others are named
// MODEL::LINK and have the link's frame.
struct SceneBody {
  std::string name;
  Pose pose;  // of the body's frame in the world
  bool isStatic = false;
  std::optional<double> mass;              // [kg]
  std::optional<Pose> inertialPose;        // center of mass and axes, in the body's frame
  std::optional<Eigen::Matrix3d> inertia;  // about the center of mass, in inertialPose's axes
  std::vector<SceneCollision> collisions;
  std::vector<SceneCollision> visuals = {};  // what is drawn of a body without collisions
  // Surface properties, one set for all collisions of a body, as in Bullet.
  std::optional<double> friction;   // mu
  std::optional<double> stiffness;  // kp [N/m]
  std::optional<double> damping;    // kd [N s/m]
  std::optional<double> restitution = {};
  Vec3 linearVelocity = Vec3::Zero();   // of the frame's origin, in the world [m/s]
  Vec3 angularVelocity = Vec3::Zero();  // in the world [rad/s]
  int model = 0;                        // bodies of one model do not touch each other ...
  bool selfCollide = false;             // ... unless the model says so
  std::optional<SceneDrive> drive = {};
  bool isSoft() const { return collisions.size() == 1 && collisions[0].soft; }
  bool isFree() const { return !isStatic && !drive; }  // forces move it
};

struct SceneDescription {
  std::string name;
  Vec3 gravity{0, 0, -9.8};  // the format's own [m/s^2]
  double step = 1e-3;        // the format's own [s]
  std::vector<SceneBody> bodies;
  std::vector<SceneJoint> joints;
};

}  // namespace cloudcontact::program
