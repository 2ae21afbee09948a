// CuttableBody: a rigid body made of a cloud that can be cut and goes on living in its world. Its
// matter stays where it is in the world, and moves as it moved; what changes is how much of it
// there is. Where a cut goes through, the body falls apart.
#pragma once

#include <BulletDynamics/Dynamics/btDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/voxels/matter_sums.h>
#include <cloudcontact/voxels/pieces.h>

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace cloudcontact {

struct CuttableBodySettings {
  std::vector<double> densities = {1000};  // [kg/m^3] one for each of the cloud's materials, or one
  std::optional<Law> law;                  // CloudShape::law
  // [kg] Pieces lighter than this do not live on: they count as cut away. So do crumbs that have no
  // surface (a lone voxel), whatever they weigh.
  double leastPiece = 0;
  int threads = 0;  // for fields: 0: all cores
};

// Matter and how it moves, in the world.
struct MovingMatter {
  double mass = 0;                      // [kg]
  Vec3 center = Vec3::Zero();           // of mass [m]
  Vec3 momentum = Vec3::Zero();         // [kg m/s]
  Vec3 angularMomentum = Vec3::Zero();  // about the world's origin [kg m^2/s]
};

class CuttableBody;

struct CutOutcome {
  // What fell off, the first voxel's piece first. In the world of the body it fell off, with its
  // friction, damping and so on. The caller's: out of the world when destroyed.
  std::vector<std::unique_ptr<CuttableBody>> fallen;
  MovingMatter cutAway;  // its mass, and the momentum that it took along
  // The body's new frame in its old one: constraints and whatever else was placed in the body's
  // frame must be placed anew by the inverse.
  Pose frame;
  bool gone = false;  // nothing is left: the body is out of its world
};

// Owns its shapes and the rigid body; owned by the caller. Never copied or moved, for Bullet keeps
// pointers to what is in it.
class CuttableBody {
 public:
  // At rest. `place`: where the cloud's frame stands. The rigid body's own frame is the centre of
  // mass and principal axes. Throws std::invalid_argument where the cloud has no surface, a density
  // is not positive or there are too few.
  CuttableBody(const Cloud& cloud, const btTransform& place,
               const CuttableBodySettings& settings = {});
  ~CuttableBody();  // takes it out of its world, which must still be there
  CuttableBody(const CuttableBody&) = delete;
  CuttableBody& operator=(const CuttableBody&) = delete;

  btRigidBody& body();
  const btRigidBody& body() const;
  CloudShape& shape();  // a child of the body's compound
  // What it is made of, in a frame that never moves against the matter, cut or not.
  const Cloud& cloud() const;
  btTransform cloudPlace() const;  // where that frame stands in the world
  MovingMatter matter() const;     // as Bullet's rigid body has it

  // The world must outlive the body, or be left first. Not world.addRigidBody(): pieces could not
  // follow.
  void addTo(btDynamicsWorld& world, int group = btBroadphaseProxy::DefaultFilter,
             int mask = btBroadphaseProxy::AllFilter);
  void leaveWorld();

  // Takes matter away, as cutCloud(); or makes the body what `after` is, which must lie in the same
  // grid and hold nowhere more (a BaseVectorField's cloud(), say). Between steps, never in a
  // callback of one. Contacts keep their names and impulses where nothing was cut. The heaviest
  // piece is the body, the others fall off. Throws as cutCloud(), and std::invalid_argument where
  // `after` does not fit; then nothing has changed.
  CutOutcome cut(std::span<const VoxelCut> cuts);
  CutOutcome become(const Cloud& after);

 private:
  struct State;
  explicit CuttableBody(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
