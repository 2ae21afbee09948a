// Timers, and surface properties written into contact points.
#include "scene/scene_dispatcher.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <map>
#include <utility>

namespace cloudcontact::program {
namespace {

using Clock = std::chrono::steady_clock;

double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double processorSeconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

int indexOf(const btCollisionObject* object) {
  return object->getUserIndex();
}

}  // namespace

double pairFriction(const SurfaceSettings& settings, int a, int b) {
  if (settings.friction) return *settings.friction;
  const auto &muA = settings.bodies[a].friction, &muB = settings.bodies[b].friction;
  if (muA && muB) return std::min(*muA, *muB);
  return muA.value_or(muB.value_or(0));
}

SceneDispatcher::SceneDispatcher(btCollisionConfiguration* configuration, SurfaceSettings settings,
                                 const CloudDispatcherSettings& clouds)
    : CloudDispatcher(configuration, clouds), settings_(std::move(settings)) {}

void SceneDispatcher::dispatchAllCollisionPairs(btOverlappingPairCache* pairs,
                                                const btDispatcherInfo& info,
                                                btDispatcher* dispatcher) {
  const auto start = Clock::now();
  const double startOfThread = processorSeconds();
  CloudDispatcher::dispatchAllCollisionPairs(pairs, info, dispatcher);
  seconds_ += since(start);
  threadSeconds_ += processorSeconds() - startOfThread;
  applySurfaces();
  if (onContacts) onContacts();
}

// Bullet combines friction by a product, and its combining functions are global pointers. The
// smaller of two values is no product, so this writes each pair's values into the points, between
// the narrow phase and the solver.
void SceneDispatcher::applySurfaces() {
  std::map<std::pair<int, int>, int> points;  // of each pair, which share its spring
  if (settings_.springsForBullet)
    for (int i = 0; i < getNumManifolds(); ++i) {
      const btPersistentManifold& manifold = *getManifoldByIndexInternal(i);
      points[std::minmax(indexOf(manifold.getBody0()), indexOf(manifold.getBody1()))] +=
          manifold.getNumContacts();
    }
  for (int i = 0; i < getNumManifolds(); ++i) {
    btPersistentManifold& manifold = *getManifoldByIndexInternal(i);
    const int a = indexOf(manifold.getBody0()), b = indexOf(manifold.getBody1());
    const auto friction = btScalar(pairFriction(settings_, a, b));
    std::optional<KelvinVoigt> material;
    if (settings_.springsForBullet)
      material = settings_.pair
                     ? settings_.pair
                     : inSeries(settings_.bodies[a].material, settings_.bodies[b].material);
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      btManifoldPoint& point = manifold.getContactPoint(k);
      point.m_combinedFriction = friction;
      if (!material) continue;
      const int sharers = points[std::minmax(a, b)];
      point.m_contactPointFlags |= BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING;
      point.m_combinedContactStiffness1 = btScalar(material->stiffness / sharers);
      point.m_combinedContactDamping1 = btScalar(material->damping / sharers);
    }
  }
}

btScalar TimedSolver::solveGroup(btCollisionObject** bodies, int bodyCount,
                                 btPersistentManifold** manifolds, int manifoldCount,
                                 btTypedConstraint** constraints, int constraintCount,
                                 const btContactSolverInfo& info, btIDebugDraw* drawer,
                                 btDispatcher* dispatcher) {
  const auto start = Clock::now();
  const btScalar result =
      NewtonSolver::solveGroup(bodies, bodyCount, manifolds, manifoldCount, constraints,
                               constraintCount, info, drawer, dispatcher);
  seconds_ += since(start);
  return result;
}

bool ModelFilter::needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const {
  const bool wanted = (a->m_collisionFilterGroup & b->m_collisionFilterMask) != 0 &&
                      (b->m_collisionFilterGroup & a->m_collisionFilterMask) != 0;
  if (!wanted) return false;
  const int indexA = indexOf(static_cast<btCollisionObject*>(a->m_clientObject));
  const int indexB = indexOf(static_cast<btCollisionObject*>(b->m_clientObject));
  if (indexA < 0 || indexB < 0) return true;  // a piece that just fell off
  const Body &bodyA = bodies_[indexA], &bodyB = bodies_[indexB];
  const bool cuts = (bodyA.isTool && bodyB.isCuttable) || (bodyB.isTool && bodyA.isCuttable);
  if (!bodyA.isFree && !bodyB.isFree && !cuts) return false;
  return bodyA.model != bodyB.model || bodyA.selfCollide;
}

}  // namespace cloudcontact::program
