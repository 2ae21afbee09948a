// Bullet's dispatcher and solver with timers. The dispatcher writes the scene's surface properties
// into the contacts, for every collision method alike, so that methods can be compared.
#pragma once

#include <btBulletDynamicsCommon.h>
#include <cloudcontact/bullet/cloud_dispatcher.h>
#include <cloudcontact/bullet/newton_solver.h>
#include <cloudcontact/law/law.h>

#include <functional>
#include <optional>
#include <vector>

namespace cloudcontact::program {

// A body's surface properties in the scene.
struct Surface {
  std::optional<double> friction;  // mu
  std::optional<KelvinVoigt> material;
};

struct SurfaceSettings {
  std::vector<Surface> bodies;      // by btCollisionObject::getUserIndex
  std::optional<double> friction;   // mu of every pair, overrides the bodies
  std::optional<KelvinVoigt> pair;  // every pair's k and c
  bool springsForBullet = false;    // write k and c into the contacts of Bullet's own algorithms
};

// mu of a pair: the smaller of the two, as in SDFormat's engine. A body without mu takes the
// other's; without both the pair is frictionless.
double pairFriction(const SurfaceSettings& settings, int a, int b);

class SceneDispatcher : public CloudDispatcher {
 public:
  // Bullet's own methods use neither threads nor a device.
  SceneDispatcher(btCollisionConfiguration* configuration, SurfaceSettings settings,
                  const CloudDispatcherSettings& clouds);

  void dispatchAllCollisionPairs(btOverlappingPairCache* pairs, const btDispatcherInfo& info,
                                 btDispatcher* dispatcher) override;

  // Called after the narrow phase, while positions and velocities are still those at the start of
  // the step.
  std::function<void()> onContacts;

  // Of the body with the next index.
  void add(const Surface& surface) { settings_.bodies.push_back(surface); }
  void set(std::size_t body, const Surface& surface) { settings_.bodies.at(body) = surface; }
  const SurfaceSettings& surfaces() const { return settings_; }

  double seconds() const { return seconds_; }
  // Processor time of the stepping thread, which other programs do not lengthen.
  double threadSeconds() const { return threadSeconds_; }

 private:
  void applySurfaces();

  SurfaceSettings settings_;
  double seconds_ = 0, threadSeconds_ = 0;
};

class TimedSolver : public NewtonSolver {
 public:
  btScalar solveGroup(btCollisionObject** bodies, int bodyCount, btPersistentManifold** manifolds,
                      int manifoldCount, btTypedConstraint** constraints, int constraintCount,
                      const btContactSolverInfo& info, btIDebugDraw* drawer,
                      btDispatcher* dispatcher) override;

  double seconds() const { return seconds_; }

 private:
  double seconds_ = 0;
};

// Skips pairs of links of one model, unless the model lets them collide, and pairs that no force
// moves, unless one cuts the other.
class ModelFilter : public btOverlapFilterCallback {
 public:
  struct Body {
    int model = 0;
    bool selfCollide = false;
    bool isFree = true;
    bool isTool = false, isCuttable = false;
  };
  explicit ModelFilter(std::vector<Body> bodies) : bodies_(std::move(bodies)) {}
  // The body with the next index.
  void add(const Body& body) { bodies_.push_back(body); }
  bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override;

 private:
  std::vector<Body> bodies_;  // by btCollisionObject::getUserIndex
};

}  // namespace cloudcontact::program
