// Bullet's dispatcher and solver with a clock each, and with what a scene says about a pair's
// surface put into the contacts. For every method alike, so that methods can be compared.
#pragma once

#include <btBulletDynamicsCommon.h>
#include <cloudcontact/bullet/cloud_dispatcher.h>
#include <cloudcontact/bullet/extrapolating_solver.h>
#include <cloudcontact/law/law.h>

#include <functional>
#include <optional>
#include <vector>

namespace cloudcontact::program {

// A body's surface as the scene states it.
struct Surface {
  std::optional<double> friction;  // mu
  std::optional<KelvinVoigt> material;
};

struct SurfaceSettings {
  std::vector<Surface> bodies;      // by btCollisionObject::getUserIndex
  std::optional<double> friction;   // every pair's mu, whatever the bodies say
  std::optional<KelvinVoigt> pair;  // every pair's k and c
  bool springsForBullet = false;          // put k and c into the contacts of Bullet's own algorithms
};

// mu of a pair: the smaller of the two, as SDFormat's engine has it; a body that states none leaves
// it to the other; where neither does, nothing rubs.
double pairFriction(const SurfaceSettings& settings, int a, int b);

class SceneDispatcher : public CloudDispatcher {
 public:
  // `threads` as CloudDispatcher's, of no use to Bullet's own methods.
  SceneDispatcher(btCollisionConfiguration* configuration, SurfaceSettings settings, int threads);

  void dispatchAllCollisionPairs(btOverlappingPairCache* pairs, const btDispatcherInfo& info,
                                 btDispatcher* dispatcher) override;

  // Called when the contacts of a step are known, positions and velocities being those of its
  // start.
  std::function<void()> onContacts;

  double seconds() const { return seconds_; }

 private:
  void applySurfaces();

  SurfaceSettings settings_;
  double seconds_ = 0;
};

class TimedSolver : public ExtrapolatingSolver {
 public:
  btScalar solveGroup(btCollisionObject** bodies, int bodyCount, btPersistentManifold** manifolds,
                      int manifoldCount, btTypedConstraint** constraints, int constraintCount,
                      const btContactSolverInfo& info, btIDebugDraw* drawer,
                      btDispatcher* dispatcher) override;

  double seconds() const { return seconds_; }

 private:
  double seconds_ = 0;
};

// Keeps the links of one model apart, unless the model says that they collide.
class ModelFilter : public btOverlapFilterCallback {
 public:
  struct Body {
    int model = 0;
    bool selfCollide = false;
  };
  explicit ModelFilter(std::vector<Body> bodies) : bodies_(std::move(bodies)) {}
  bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override;

 private:
  std::vector<Body> bodies_;  // by btCollisionObject::getUserIndex
};

}  // namespace cloudcontact::program
