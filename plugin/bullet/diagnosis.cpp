// One table of checks of the solver's settings, and a walk over the shapes beside clouds.
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletDynamics/ConstraintSolver/btConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDynamicsWorld.h>
#include <cloudcontact/bullet/diagnosis.h>
#include <cloudcontact/bullet/shape_report.h>

#include "bullet/look_ahead.h"
#include "bullet/pair_law.h"
#include "bullet/shape_conversion.h"
#include "bullet/shape_triangles.h"

namespace cloudcontact {

namespace {

constexpr int kModes = SOLVER_USE_WARMSTARTING | SOLVER_USE_2_FRICTION_DIRECTIONS |
                       SOLVER_ENABLE_FRICTION_DIRECTION_CACHING;

struct Check {
  bool wrong;
  const char* advice;
};

// The shapes of a world beside one of its clouds.
class ShapeChecks {
 public:
  ShapeChecks(const ShapeReport& cloud, btDispatcher& dispatcher, std::vector<std::string>& advice)
      : cloud_(cloud), dispatcher_(dispatcher), advice_(advice) {}

  void check(const btCollisionObject& object, const btCollisionShape& shape) {
    if (shape.isSoftBody()) return;
    if (shape.isCompound()) {
      const auto& compound = static_cast<const btCompoundShape&>(shape);
      for (int i = 0; i < compound.getNumChildShapes(); ++i)
        check(object, *compound.getChildShape(i));
      return;
    }
    const std::string name = "Object " + std::to_string(object.getWorldArrayIndex()) +
                             " of the world has a shape (" + shape.getName() + ") that ";
    if (const CloudShape* const own = CloudShape::of(shape); own && !own->scalesEvenly())
      advice_.push_back(name +
                        "is scaled unevenly or not positively, so it touches nothing: scale the "
                        "mesh and digitize it again.");
    const bool cloud = CloudShape::of(shape) != nullptr;
    if (!cloud && !hasTriangles(shape) && !toSolid(shape))
      advice_.push_back(name +
                        "touches no cloud, since it has neither volume nor triangles: make it a "
                        "triangle mesh, a btCompoundShape or a CloudShape.");
    else if (!isOurs(object, shape))
      advice_.push_back(name +
                        "another algorithm than CloudContact's takes beside clouds: call "
                        "CloudContact::attach() on the world's dispatcher, after all other "
                        "registrations and before the objects are added.");
  }

 private:
  bool isOurs(const btCollisionObject& object, const btCollisionShape& shape) {
    const btCollisionObjectWrapper one(nullptr, cloud_.shape, cloud_.object,
                                       cloud_.object->getWorldTransform(), -1, -1);
    const btCollisionObjectWrapper other(nullptr, &shape, &object, object.getWorldTransform(), -1,
                                         -1);
    btCollisionAlgorithm* const found =
        dispatcher_.findAlgorithm(&one, &other, nullptr, BT_CONTACT_POINT_ALGORITHMS);
    if (!found) return false;
    const bool ours = dynamic_cast<AheadPair*>(found) != nullptr;
    found->~btCollisionAlgorithm();
    dispatcher_.freeCollisionAlgorithm(found);
    return ours;
  }

  const ShapeReport& cloud_;
  btDispatcher& dispatcher_;
  std::vector<std::string>& advice_;
};

void checkShapes(const btDynamicsWorld& world, std::vector<std::string>& advice) {
  const std::vector<ShapeReport> clouds = shapeReport(world);
  if (clouds.empty()) return;
  // Bullet has no const access to the dispatcher.
  btDispatcher& dispatcher = *const_cast<btDynamicsWorld&>(world).getDispatcher();
  ShapeChecks checks(clouds.front(), dispatcher, advice);
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i) {
    checks.check(*objects[i], *objects[i]->getCollisionShape());
    if (const char* const wrong = wrongMaterial(*objects[i]))
      advice.push_back("Object " + std::to_string(i) + " of the world touches no cloud: " + wrong +
                       ".");
  }
}

}  // namespace

std::vector<std::string> diagnose(const btDynamicsWorld& world) {
  const btContactSolverInfo& info = world.getSolverInfo();
  // Bullet has no const access to the solver.
  const btConstraintSolver* const solver =
      const_cast<btDynamicsWorld&>(world).getConstraintSolver();
  const auto lacks = [&info](int mode) { return !(info.m_solverMode & mode); };
  const Check checks[] = {
      {info.m_splitImpulse != 0,
       "getSolverInfo().m_splitImpulse is on, which drops the spring from contacts deeper than "
       "m_splitImpulsePenetrationThreshold: set it to 0."},
      {solver && solver->getSolverType() == BT_MLCP_SOLVER,
       "The world's solver is an MLCP solver, which ignores contact stiffness and damping: build "
       "the world with btSequentialImpulseConstraintSolver."},
      {lacks(SOLVER_USE_WARMSTARTING),
       "Warm starting is off, so every step starts its contacts from nothing: add "
       "SOLVER_USE_WARMSTARTING to getSolverInfo().m_solverMode."},
      {info.m_warmstartingFactor < 1,
       "getSolverInfo().m_warmstartingFactor is below 1, so every step drops a part of what "
       "holds a stack: set it to 1."},
      {lacks(SOLVER_USE_2_FRICTION_DIRECTIONS),
       "Contacts rub in one direction only, which topples stacks: add "
       "SOLVER_USE_2_FRICTION_DIRECTIONS to getSolverInfo().m_solverMode."},
      {lacks(SOLVER_ENABLE_FRICTION_DIRECTION_CACHING),
       "Bullet replaces the contacts' friction directions by its own, which hold the gravity "
       "step: add SOLVER_ENABLE_FRICTION_DIRECTION_CACHING to getSolverInfo().m_solverMode."},
      {info.m_linearSlop != 0,
       "getSolverInfo().m_linearSlop is taken off every depth, so contacts press too little: set "
       "it to 0."},
  };
  std::vector<std::string> advice;
  for (const Check& check : checks)
    if (check.wrong) advice.emplace_back(check.advice);
  checkShapes(world, advice);
  return advice;
}

void recommendedSettings(btDynamicsWorld& world) {
  btContactSolverInfo& info = world.getSolverInfo();
  info.m_splitImpulse = 0;
  info.m_solverMode |= kModes;
  info.m_warmstartingFactor = 1;
  info.m_linearSlop = 0;
}

}  // namespace cloudcontact
