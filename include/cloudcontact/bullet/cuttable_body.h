// CuttableBody: a rigid body made of a cloud, which can be cut while it is in its world. The matter
// that is left keeps its place and motion. A body that is cut through falls apart. A cut is felt at
// once; the edges that it leaves are blunt until the steps that follow have sharpened them.
#pragma once

#include <BulletDynamics/Dynamics/btDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <cloudcontact/base/span.h>
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/voxels/matter_sums.h>
#include <cloudcontact/voxels/pieces.h>

#include <memory>
#include <optional>
#include <vector>

namespace cloudcontact {

// How a cloud becomes a body that can be cut.
struct CuttableBodySettings {
  std::vector<double> densities = {1000};  // [kg/m^3] one per material of the cloud, or one for all
  std::optional<Law> law;                  // CloudShape::law
  // [kg] Lighter pieces count as cut away, as do crumbs without a surface (a lone voxel).
  double leastPiece = 0;
  int threads = 0;  // for fields; 0: all cores
};

// Matter and its motion, in the world.
struct MovingMatter {
  double mass = 0;                      // [kg]
  Vec3 center = Vec3::Zero();           // of mass [m]
  Vec3 momentum = Vec3::Zero();         // [kg m/s]
  Vec3 angularMomentum = Vec3::Zero();  // about the world's origin [kg m^2/s]
};

class CuttableBody;

// What became of a body by a cut.
struct CutOutcome {
  // The pieces that fell off, ordered by their first voxels in each cut. They are in the body's
  // world, with its friction, damping and so on, and leave it when destroyed. The caller owns them.
  std::vector<std::unique_ptr<CuttableBody>> fallen;
  MovingMatter cutAway;
  // The body's new frame in its old one. Multiply constraint frames and other things placed in the
  // body's frame by the inverse.
  Pose frame;
  bool gone = false;  // nothing is left: the body is out of its world
};

// Owns its shapes and the rigid body. Not movable, because Bullet keeps pointers into it.
class CuttableBody {
 public:
  // At rest. `place` is the transform of the cloud's frame; the rigid body's own frame is the
  // center of mass and the principal axes. Throws std::invalid_argument if the cloud has no
  // surface, a density is not positive or missing, or leastPiece is negative.
  CuttableBody(const Cloud& cloud, const btTransform& place,
               const CuttableBodySettings& settings = {});
  ~CuttableBody();  // removes it from its world, which must still exist
  CuttableBody(const CuttableBody&) = delete;
  CuttableBody& operator=(const CuttableBody&) = delete;

  btRigidBody& body();
  const btRigidBody& body() const;
  CloudShape& shape();  // a child of the body's compound
  // The matter, in a frame that cuts do not move.
  const Cloud& cloud() const;
  btTransform cloudPlace() const;  // that frame in the world
  MovingMatter matter() const;     // of Bullet's rigid body
  double volume() const;           // of the matter [m^3]

  // The world must outlive the body, or the body must leave it first. Use this instead of
  // world.addRigidBody(), so that pieces enter the same world.
  void addTo(btDynamicsWorld& world, int group = btBroadphaseProxy::DefaultFilter,
             int mask = btBroadphaseProxy::AllFilter);
  void leaveWorld();
  btDynamicsWorld* world();  // null outside a world

  // Removes material, as cutCloud() does; or sets the matter to `after`, which must have the same
  // grid and nowhere more matter (the cloud() of a BaseVectorField, for example). Call them between
  // steps, never in a callback. Contacts keep their IDs and impulses where nothing was cut. The
  // heaviest piece stays the body, the others fall off. Throw as cutCloud() does, and
  // std::invalid_argument if `after` does not fit; then nothing has changed.
  CutOutcome cut(Span<const VoxelCut> cuts);
  CutOutcome become(const Cloud& after);

  // The same without a pause, however large the cut, for loops that must not wait. Cloud, mass and
  // motion follow at once. What contacts feel, and the pieces that fall off, follow in this call
  // and those after it, each of which works for a few milliseconds (3.5 on one core of the machine
  // that set it; by counts, so every run is the same): a bite of 250 voxels needs one, sawing
  // through a body of 115,000 ten. Returns what has come about by now, also of earlier cuts: call
  // goOn() in steps without a cut while behind(). (Without these calls the world's steps do the
  // work, but pieces wait for one of them.) Throws as cutCloud() does.
  // `share`: of such a call's work; for several bodies in one step.
  CutOutcome cutGradually(Span<const VoxelCut> cuts, double share = 1);
  CutOutcome goOn(double share = 1);
  bool behind() const;  // gradual cuts are not yet all felt

  // Where the surface was cut, its edges are found later (SurfaceField::unsettled()): a fixed
  // number of searches in each cut, and in each step of the world without one. So every run is the
  // same. This finds all at once, and ends gradual cuts; shape().field() then equals
  // SurfaceField::build(cloud()).
  CutOutcome settle();

 private:
  struct State;
  explicit CuttableBody(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
