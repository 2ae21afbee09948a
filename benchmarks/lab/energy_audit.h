// EnergyAudit: where the energy of a Bullet world goes in each step, and which rows make some.
//
// A step takes velocities from v0 to v1 by M (v1 - v0) = sum of J p, the impulses p of all rows and
// forces. Times v1, and at a constant inertia, this is exact:
//
//   T1 - T0 = sum of p (J v1) + h forces . v1 - (v1 - v0) M (v1 - v0) / 2
//
// Bullet moves bodies by h v1, so that gravity's part is what they lose in height. Its rows ask for
// speeds J v1, too. So a right row of friction has no positive p (J v1), and a right one on a
// spring none beyond what the spring gives back on the way h (J v1). The last term is never
// positive. Half of v0 + v1 for v1 needs no such term, but then a right row that holds a body
// against another push seems to make what the other takes.
#pragma once

#include <btBulletDynamicsCommon.h>
#include <cloudcontact/base/pose.h>

#include <map>
#include <memory>
#include <tuple>
#include <vector>

namespace cloudcontact::program::lab {

// [J] of one step, or of all so far: bodies + springs = friction + normals + joints + drivers
// + solver + turning + rest, by its definition.
struct EnergyParts {
  double bodies = 0;    // change of the free bodies' energy, kinetic and of gravity
  double springs = 0;   // change of what the contacts' springs store, while the bodies move
  double friction = 0;  // work of the rows of friction
  double normals = 0;   // work of normal rows and the change of their springs: less than 0 damps
  double joints = 0;    // work of joints
  double drivers = 0;   // work of kinematic bodies
  double solver = 0;    // -(v1 - v0) M (v1 - v0) / 2: what implicit steps take
  double turning = 0;   // gyroscopic torques, and inertia that turns with its body
  double rest = 0;      // none of these: rounding, damping of bodies, rolling friction
  // Beside that balance: change of what the springs store between the last step's end and the next
  // narrow phase, by new depths, stiffnesses and points.
  double found = 0;

  EnergyParts& operator+=(const EnergyParts& other);
};

// Spring is no row of the solver, but what the narrow phase found: a point's spring stores more
// than it was left with, or is new.
enum class RowKind { Normal, Friction1, Friction2, Spring };

// A row that made energy in a step.
struct EnergyRow {
  const btCollisionObject *a = nullptr, *b = nullptr;
  RowKind kind = RowKind::Normal;
  int point = 0;  // m_partId0: CloudContact's ID of the point
  long step = 0;  // from 1
  double energy = 0;
  bool isNew = false;     // the pair had no such point in the step before
  bool patchNew = false;  // nor any other point of its manifold
  bool renamed = false;   // a point that is gone was nearer to it than any that is there
};

// What rows of one kind made, in all steps. Of Bullet's own shapes, whose points have no IDs,
// springs are not told apart.
struct EnergyMade {
  long rows = 0;
  double energy = 0, byNew = 0;  // [J]; byNew: of it by points that were new
  EnergyRow worst;               // its energy is 0 where no row made any
};

// Add it last of the world's actions. Joints get a btJointFeedback while they have none. Contacts
// count that are solved with SOLVER_USE_WARMSTARTING, without which Bullet keeps no impulses.
class EnergyAudit : public btActionInterface {
 public:
  explicit EnergyAudit(btDynamicsWorld& world);
  ~EnergyAudit() override;
  EnergyAudit(const EnergyAudit&) = delete;
  EnergyAudit& operator=(const EnergyAudit&) = delete;

  // Before each step of `seconds`; a step without it does not count.
  void begin(double seconds);

  long steps() const { return steps_; }
  const EnergyParts& step() const { return step_; }
  const EnergyParts& sum() const { return sum_; }
  const EnergyMade& made(RowKind kind) const { return made_[static_cast<int>(kind)]; }
  const EnergyRow& worst() const;  // of the solver's rows

  void updateAction(btCollisionWorld* world, btScalar step) override;
  void debugDraw(btIDebugDraw*) override {}

 private:
  // A free body at the start of a step.
  struct Start {
    double energy = 0;
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero(), center = Vec3::Zero();
    Vec3 gyroscopic = Vec3::Zero();  // impulse [N m s]
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  };
  // One body of a row.
  struct Side {
    Vec3 before = Vec3::Zero(), after = Vec3::Zero();  // velocity at the point
    bool driven = false;
  };
  // A contact point: its place in the first body's frame, and what its spring was left with.
  struct Known {
    Vec3 place = Vec3::Zero();
    double left = 0;
  };
  using Points = std::map<std::tuple<const void*, const void*, int>, Known>;  // by pair and ID

  Start startOf(const btRigidBody& body, double seconds) const;
  Side sideOf(const btCollisionObject& object, const Vec3& place) const;
  void addBodies();
  void addContacts();
  void addManifold(const btPersistentManifold& manifold);
  void addPoint(const btManifoldPoint& point, const EnergyRow& row, const Side& a, const Side& b);
  void addJoints();
  void addJointSide(const btRigidBody& body, const btVector3& force, const btVector3& torque);
  double work(const Vec3& impulse, const Side& a, const Side& b);
  double springs(const btManifoldPoint& point, const EnergyRow& row, double parting);
  void note(EnergyRow row, RowKind kind, double energy);
  bool wasThere(const EnergyRow& row) const;
  bool isRenamed(const btPersistentManifold& manifold, const EnergyRow& row,
                 const Vec3& place) const;

  btDynamicsWorld& world_;
  std::map<btTypedConstraint*, std::unique_ptr<btJointFeedback>> feedback_;
  std::vector<Start> starts_;  // by the index in the world
  Points before_, now_;
  double seconds_ = 0;
  bool begun_ = false;
  double stored_ = 0, left_ = 0;  // by springs, at the step's start and end
  long steps_ = 0;
  EnergyParts step_, sum_;
  EnergyMade made_[4];
};

}  // namespace cloudcontact::program::lab
