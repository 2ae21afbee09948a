// A scene as a running Bullet world.
#pragma once

#include <cloudcontact/bullet/pair_report.h>
#include <cloudcontact/bullet/world_state.h>
#include <cloudcontact/contact/work_counts.h>
#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/voxels/voxel_cut.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/options.h"
#include "scene/drawn_body.h"
#include "scene/penetration.h"
#include "scene/scene.h"

class btDiscreteDynamicsWorld;

namespace cloudcontact::program {

struct ShapeStore;  // shape_store.h

struct WorldSettings {
  CommonOptions common;
  double voxel = 0;  // [m], must be set
  // Sweeps of the solver a step. Empty: Bullet's ten, and with clouds until the rows agree.
  std::optional<int> iterations = {};
  bool sleep = false;                      // lets bodies at rest fall asleep
  std::shared_ptr<ShapeStore> store = {};  // shared with worlds of equal bodies
};

// A body's state, in the scene body's own frame.
struct BodyState {
  Pose pose;
  Vec3 linearVelocity = Vec3::Zero();  // of the frame's origin [m/s]
  Vec3 angularVelocity = Vec3::Zero();
  bool asleep = false;
};

// The energy of a scene [J]. Springs are separate: a body that arrives between two steps finds its
// spring already compressed, by up to v h. No body had that energy and damping removes it, so the
// total may exceed that of the start although no body gains energy.
struct Energy {
  double kinetic = 0;
  double potential = 0;  // in gravity, zero at the world's origin
  double spring = 0;     // sum of k d^2 / 2 over contacts with a stiffness
  double elastic = 0;    // in bodies that deform
  double cutAway = 0;    // left with what was cut away, kinetic, potential and elastic
  double ofBodies() const { return kinetic + potential + elastic; }
};

// What a device did of all steps (--backend opencl).
struct DeviceUse {
  std::string name;                  // empty: none is in use
  std::string failure;               // why it is no longer used
  std::size_t steps = 0, least = 0;  // that used it; `least` pairs to search make it pay
  std::size_t pairs = 0, onCpu = 0;  // in these steps: those that it searched, and the others
};

// Results of the latest narrow phase, with the energy at the start of its step, to which the depths
// belong.
struct ContactMoment {
  Energy energy;
  int pairs = 0;       // of bodies in contact
  int contacts = 0;    // points
  double deepest = 0;  // of the points, by the method under test [m]
};

// A contact point between two steps, of any method. `force` is that of body a on body b, with
// friction: the mean over the latest step [N].
struct ContactNow {
  Vec3 position = Vec3::Zero();  // midway between the surfaces, moved with the bodies [m]
  Vec3 normal = Vec3::UnitZ();   // from a to b
  Vec3 force = Vec3::Zero();
  double depth = 0;  // [m] positive inside, at the start of the step
};

// One manifold; for clouds a patch of the pair's contact.
struct PatchNow {
  int a = -1, b = -1;                 // btCollisionObject::getUserIndex
  std::size_t first = 0, points = 0;  // in ContactsNow::points
};

struct ContactsNow {
  std::vector<PatchNow> patches;
  std::vector<ContactNow> points;  // of all patches, in order

  std::span<const ContactNow> of(const PatchNow& patch) const {
    return {points.data() + patch.first, patch.points};
  }
};

// What was cut off a body so far.
struct CutRecord {
  double volume = 0;  // removed [m^3], without the pieces
  double mass = 0;    // removed [kg]
  int pieces = 0;     // that fell off and live on as bodies
  bool gone = false;  // nothing is left of the body
};

// A spring between a point of a body and a place in the world: a hand that pulls, or holds.
struct BodyPull {
  std::size_t body = 0;
  Vec3 grip = Vec3::Zero();  // in the body's frame [m]
  Vec3 to = Vec3::Zero();    // in the world [m]
  double stiffness = 0;      // [N/m]
  double damping = 0;        // of the grip's velocity in the world [N s/m]
  // The hand gives way: beyond this stretch the spring pulls no harder [m].
  double reach = 0;
  const void* holder = nullptr;  // whoever set it, to know it again; nothing else asks
};

// What pushes a body in each step, beside gravity and contacts.
struct BodyLoad {
  Vec3 force = Vec3::Zero();   // at the center of mass [N]
  Vec3 torque = Vec3::Zero();  // about it, in the world's axes [N m]
};

// A body that deforms.
struct SoftRecord {
  int nodes = 0, links = 0;  // now
  int cut = 0;               // links that were cut
  int pieces = 0;            // parts that hold together
};

// A cloud that meets others as a shape.
struct KnownShape {
  std::size_t body = 0;
  std::string kind;  // "ball", "box" ...
  double error = 0;  // [m]
};

// What the steps so far took, in counts that no machine changes.
struct WorkDone {
  std::size_t pairs = 0;  // of clouds, asked for contacts
  WorkCounts contacts;
  std::size_t sweeps = 0;  // of the solver
  std::size_t newton = 0;  // its Newton steps
  std::size_t bytes = 0;   // that the pairs of now keep between steps
};

// Where a driven body began to move as it does now.
struct DriveStart {
  Pose pose;                   // of its frame then
  double time = 0;             // [s]
  Vec3 linear = Vec3::Zero();  // SceneDrive::linear, angular
  Vec3 angular = Vec3::Zero();
};

// Of a joint: what the poses of its bodies do not tell.
struct JointSave {
  std::array<double, 2> places = {};  // AxisState::place
  std::array<JointMotor, 2> motors;
  JointLoad load;
};

// A state of a world. Numbers are those of the bodies, in their order.
struct WorldSave {
  WorldState bullet;
  std::vector<JointSave> joints;
  double time = 0, latestStep = 0;  // [s]
  ContactMoment moment;
  std::vector<BodyLoad> loads;
  std::vector<DriveStart> drives;  // of driven bodies, else of no meaning
  std::vector<double> volumes;     // of those that can be cut, else 0 [m^3]
};

// How two bodies met, all steps together.
struct PairUse {
  std::size_t a = 0, b = 0;  // bodies
  PairReport report;
};

class World {
 public:
  // Throws BadInput naming an unusable body, file or option.
  World(const SceneDescription& scene, const WorldSettings& settings);
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // Throws WorkFailed if a state is not finite.
  void step(double seconds);
  // Finds contacts at the current poses, without a step.
  void findContacts();
  // The state between two steps, and back to it: the world goes on as it did from there, to the
  // bit. The world may be another one of the same scene. Loads come back, pulls stay as they are.
  // save() throws BadInput where a body deforms, restore() where the state is of another scene or
  // a body was cut since.
  WorldSave save() const;
  void restore(const WorldSave& save);

  // Pieces that fall off a body that is cut become bodies behind the others.
  std::size_t bodyCount() const;
  const std::string& name(std::size_t body) const;
  bool isStatic(std::size_t body) const;
  bool isCuttable(std::size_t body) const;
  // Of a body that can be cut: its matter, in a frame that stays at matterPlace(body) in the body's
  // frame.
  const Cloud& matter(std::size_t body) const;
  const Pose& matterPlace(std::size_t body) const;
  const CutRecord& cutOf(std::size_t body) const;
  // Removes voxels. Call it between steps.
  void cut(std::size_t body, std::span<const VoxelCut> cuts);
  // Whether forces move it as a rigid body: it is neither static nor driven, nor does it deform.
  bool isPullable(std::size_t body) const;
  // A pull that fits the body: its own weight (on Earth) stretches the spring by a tenth of its
  // radius, the spring gives way at a radius, so that it pulls with ten times the weight at most,
  // and damping is critical. Softer where steps of this length [s] ask for it.
  BodyPull pullOf(std::size_t body, const Vec3& grip, const Vec3& to, double step) const;
  // Springs that pull in each step from now on, instead of those before. The force is that of the
  // start of the step, so k and c must not be too large for it. Throws std::invalid_argument for a
  // body that is not pullable, and values that are negative or not finite.
  void setPulls(std::vector<BodyPull> pulls);
  const std::vector<BodyPull>& pulls() const;
  // Of each pull in the latest step [N].
  const std::vector<Vec3>& pullForces() const;
  // From now on, in each step. These three throw std::invalid_argument for a body that is not
  // pullable, and for numbers that are not finite.
  void setLoad(std::size_t body, const BodyLoad& load);
  const BodyLoad& load(std::size_t body) const;
  // Velocity of the frame's origin [m/s] and of the turn [rad/s].
  void setMotion(std::size_t body, const Vec3& velocity, const Vec3& angularVelocity);
  // The body as it is described, with what change() has set.
  const SceneBody& described(std::size_t body) const;
  // From the next step on it has the friction, stiffness, damping, restitution, mass and drive of
  // `like`. The inertia changes as the mass does; a drive goes on from where the body is. Throws
  // BadInput for values that a scene may not have, std::invalid_argument for a mass or a drive that
  // the body cannot have.
  void change(std::size_t body, const SceneBody& like);
  // Puts a body's frame elsewhere, with the velocity that it has. Call it between steps.
  void place(std::size_t body, const Pose& pose);
  // In the order of the scene. Those that name one throw std::out_of_range where there is none,
  // or it has no such axis.
  std::size_t jointCount() const;
  const SceneJoint& describedJoint(std::size_t joint) const;
  JointState joint(std::size_t joint) const;
  AxisState axis(std::size_t joint, std::size_t axis) const;
  const JointMotor& motor(std::size_t joint, std::size_t axis) const;
  // From the next step on. Throws std::invalid_argument for gains below 0, and numbers that are not
  // finite where they must be.
  void setMotor(std::size_t joint, std::size_t axis, const JointMotor& motor);
  // The frame of a body that deforms moves with its center of mass, and never turns.
  bool isSoft(std::size_t body) const;
  std::vector<KnownShape> knownShapes() const;
  // With CommonOptions::explain; of clouds only.
  std::vector<PairUse> pairs() const;
  SoftRecord softRecord(std::size_t body) const;
  Mesh softSurface(std::size_t body) const;  // in the body's frame
  BodyState state(std::size_t body) const;
  const Pose& pose(std::size_t body) const;  // state(body).pose; computed once a step
  const ContactMoment& moment() const;
  // The contacts after the latest step; none before the first. Reuses the memory of `now`.
  void contacts(ContactsNow& now) const;
  const DrawnBody& drawn(std::size_t body) const;
  double mass(std::size_t body) const;  // [kg], 0 for a static or driven body

  // Largest penetration now, over all pairs that may collide [m]. Bodies without a mesh, and those
  // that can be cut, are left out.
  double penetration() const;
  bool isMeasured(std::size_t body) const;
  bool measuresPenetration() const;  // of any pair
  // Number of lookups of penetration().
  std::size_t probes() const;

  // What runs the scene, to be observed. Its objects' user indices are the bodies.
  btDiscreteDynamicsWorld& bullet();
  // diagnose() of the Bullet world, for clouds; its objects are the bodies.
  std::vector<std::string> advice() const;
  double narrowPhaseSeconds() const;
  double narrowPhaseThreadSeconds() const;  // processor time of the stepping thread
  DeviceUse deviceUse() const;
  double solverSeconds() const;
  WorkDone work() const;
  // FNV-1a over the bits of all states, to compare runs.
  std::uint64_t hash() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact::program
