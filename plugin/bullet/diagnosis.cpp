// One table of checks of the solver's settings, a walk over the shapes beside clouds, and one over
// the pairs of stated laws.
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletDynamics/ConstraintSolver/btConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDynamicsWorld.h>
#include <cloudcontact/bullet/diagnosis.h>
#include <cloudcontact/bullet/newton_solver.h>
#include <cloudcontact/bullet/shape_report.h>

#include <initializer_list>
#include <stdexcept>

#include "bullet/cloud_algorithm.h"
#include "bullet/matter_check.h"
#include "bullet/pair_law.h"
#include "bullet/shape_conversion.h"
#include "bullet/shape_parts.h"
#include "bullet/shape_triangles.h"
#include "bullet/soft_pair.h"
#include "bullet/solver_settings.h"

namespace cloudcontact {

namespace {

struct Check {
  bool wrong;
  const char* advice;
};

std::string nameOf(const btCollisionObject& object) {
  return "Object " + std::to_string(object.getWorldArrayIndex()) + " of the world";
}

// The shapes of a world beside one of its clouds.
class ShapeChecks {
 public:
  ShapeChecks(const ShapeReport& cloud, btDispatcher& dispatcher, std::vector<std::string>& advice)
      : cloud_(cloud), dispatcher_(dispatcher), advice_(advice) {}

  void check(const btCollisionObject& object, const btCollisionShape& shape) {
    if (shape.isSoftBody()) {
      const btSoftBody* const soft = btSoftBody::upcast(&object);
      if (const char* const wrong = soft ? wrongSoft(*soft) : nullptr)
        advice_.push_back(nameOf(object) + ": " + wrong + ".");
      return;
    }
    const std::string whole = nameOf(object);
    const std::string name = whole + " has a shape (" + shape.getName() + ") that ";
    const CloudShape* const own = CloudShape::of(shape);
    if (own) checkLaw(whole, *own);
    if (own && !own->scalesEvenly())
      advice_.push_back(name +
                        "is scaled unevenly or not positively, so it touches nothing: scale the "
                        "mesh and digitize it again.");
    if (!own && !hasTriangles(shape) && !toSolid(shape))
      advice_.push_back(name +
                        "touches no cloud, since it has neither volume nor triangles: make it a "
                        "triangle mesh, a btCompoundShape or a CloudShape.");
    else if (!isOurs(object, shape))
      advice_.push_back(name +
                        "another algorithm than CloudContact's takes beside clouds: call "
                        "CloudContact::attach() on the world's dispatcher, after all other "
                        "registrations and before the objects are added.");
  }

  // Of the algorithm that takes pairs of clouds; null if none of ours does.
  const CloudContactSettings* settings() const { return settings_; }

 private:
  void checkLaw(const std::string& whole, const CloudShape& cloud) {
    try {
      if (cloud.law) validate(*cloud.law);
    } catch (const std::invalid_argument& why) {
      advice_.push_back(whole + " touches nothing, since its law is none: " + why.what() +
                        "; set CloudShape::law.");
    }
  }
  bool isOurs(const btCollisionObject& object, const btCollisionShape& shape) {
    const btCollisionObjectWrapper one(nullptr, cloud_.shape, cloud_.object,
                                       cloud_.object->getWorldTransform(), -1, -1);
    const btCollisionObjectWrapper other(nullptr, &shape, &object, object.getWorldTransform(), -1,
                                         -1);
    btCollisionAlgorithm* const found =
        dispatcher_.findAlgorithm(&one, &other, nullptr, BT_CONTACT_POINT_ALGORITHMS);
    if (!found) return false;
    const auto* const ours = dynamic_cast<CloudAlgorithm*>(found);
    if (ours) settings_ = &ours->settings();
    found->~btCollisionAlgorithm();
    dispatcher_.freeCollisionAlgorithm(found);
    return ours != nullptr;
  }

  const CloudContactSettings* settings_ = nullptr;
  const ShapeReport& cloud_;
  btDispatcher& dispatcher_;
  std::vector<std::string>& advice_;
};

// A shape that states a law or tissues, alone or as a compound's child.
struct StatingShape {
  const btCollisionObject& object;
  const btCollisionShape& shape;

  btCollisionObjectWrapper wrapped() const {
    return {nullptr, &shape, &object, object.getWorldTransform(), -1, -1};
  }
};

void addStating(const btCollisionObject& object, const btCollisionShape& shape,
                std::vector<StatingShape>& stated) {
  const CloudShape* const cloud = CloudShape::of(shape);
  const bool byBullet =
      object.getCollisionFlags() & btCollisionObject::CF_HAS_CONTACT_STIFFNESS_DAMPING;
  if (byBullet || shape.isSoftBody() || (cloud && (cloud->law || !cloud->tissues().empty())))
    stated.push_back({object, shape});
}

bool mayMeet(const StatingShape& a, const StatingShape& b) {
  if (&a.object == &b.object || (!CloudShape::of(a.shape) && !CloudShape::of(b.shape)))
    return false;
  const btBroadphaseProxy* const p = a.object.getBroadphaseHandle();
  const btBroadphaseProxy* const q = b.object.getBroadphaseHandle();
  return p && q && (p->m_collisionFilterGroup & q->m_collisionFilterMask) &&
         (q->m_collisionFilterGroup & p->m_collisionFilterMask) &&
         a.object.checkCollideWith(&b.object);
}

// Why the pair has no law; empty if it has one. The law of one body alone is checked elsewhere.
std::string whyNoLaw(const CloudContactSettings& settings, const StatingShape& a,
                     const StatingShape& b) {
  try {
    const btCollisionObjectWrapper one = a.wrapped(), other = b.wrapped();
    constexpr double kAny = 1;  // voxel and step
    lawOf(settings, one, other, kAny, kAny);
  } catch (const std::runtime_error& why) {
    return why.what();
  } catch (const std::invalid_argument&) {
  }
  return {};
}

// The first pair whose laws do not go together; the others are told once it is mended.
void checkLaws(const btDynamicsWorld& world, const CloudContactSettings& settings,
               std::vector<std::string>& advice) {
  std::vector<StatingShape> stated;
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i)
    forEachPart(*objects[i]->getCollisionShape(), objects[i]->getWorldTransform(),
                [&](const btCollisionShape& part, const btTransform&, int) {
                  addStating(*objects[i], part, stated);
                });
  for (std::size_t i = 0; i < stated.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      if (!mayMeet(stated[k], stated[i])) continue;
      const std::string why = whyNoLaw(settings, stated[k], stated[i]);
      if (why.empty()) continue;
      advice.push_back(nameOf(stated[k].object) + " has no contacts with object " +
                       std::to_string(stated[i].object.getWorldArrayIndex()) + ": " + why + ".");
      return;
    }
}

void checkShapes(const btDynamicsWorld& world, std::vector<std::string>& advice) {
  const std::vector<ShapeReport> clouds = shapeReport(world);
  if (clouds.empty()) return;
  // Bullet has no const access to the dispatcher.
  btDispatcher& dispatcher = *const_cast<btDynamicsWorld&>(world).getDispatcher();
  ShapeChecks checks(clouds.front(), dispatcher, advice);
  CloudMasses masses;
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i) {
    forEachPart(*objects[i]->getCollisionShape(), objects[i]->getWorldTransform(),
                [&](const btCollisionShape& part, const btTransform&, int) {
                  checks.check(*objects[i], part);
                });
    const std::string name = nameOf(*objects[i]);
    if (const char* const wrong = wrongMaterial(*objects[i]))
      advice.push_back(name + " touches no cloud: " + wrong + ".");
    for (const char* const wrong : wrongMatter(*objects[i], masses))
      advice.push_back(name + ": " + wrong + ".");
  }
  if (checks.settings()) checkLaws(world, *checks.settings(), advice);
}

// Whether the solver takes what recommend() sets by itself, where clouds are.
bool recommendsItself(const btConstraintSolver* solver) {
  const auto* const own = dynamic_cast<const NewtonSolver*>(solver);
  return own && own->cloudsOnly;
}

bool sweepsAlone(const btConstraintSolver* solver) {
  const auto* const own = dynamic_cast<const NewtonSolver*>(solver);
  return !own || !own->newton || own->mostSweeps == 0;
}

void tell(std::initializer_list<Check> checks, std::vector<std::string>& advice) {
  for (const Check& check : checks)
    if (check.wrong) advice.emplace_back(check.advice);
}

void checkModes(const btContactSolverInfo& info, const btConstraintSolver* solver,
                std::vector<std::string>& advice) {
  const auto lacks = [&info](int mode) { return !(info.m_solverMode & mode); };
  tell(
      {
          {info.m_splitImpulse != 0,
           "getSolverInfo().m_splitImpulse is on, which drops the spring from contacts deeper than "
           "m_splitImpulsePenetrationThreshold: set it to 0."},
          {solver && solver->getSolverType() == BT_MLCP_SOLVER,
           "The world's solver is an MLCP solver, which ignores contact stiffness and damping: "
           "build the world with btSequentialImpulseConstraintSolver."},
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
           "getSolverInfo().m_linearSlop is taken off every depth, so contacts press too little: "
           "set it to 0."},
      },
      advice);
}

void checkNumbers(const btContactSolverInfo& info, const btConstraintSolver* solver,
                  std::vector<std::string>& advice) {
  tell(
      {
          {sweepsAlone(solver) && info.m_numIterations < kFewestSweeps,
           "getSolverInfo().m_numIterations is below 4, fewer sweeps than a contact has points: "
           "set it to 10, or build the world with NewtonSolver."},
          {!(info.m_leastSquaresResidualThreshold <= kMostResidual),
           "getSolverInfo().m_leastSquaresResidualThreshold is above 1e-4 (m/s)^2, so the solver "
           "stops before contacts bear their weight: set it to 0."},
          {!(info.m_sor > 0 && info.m_sor <= kMostRelaxation),
           "getSolverInfo().m_sor is not in (0, 1.7], so sweeps overshoot and bodies jump: set it "
           "to 1."},
          {info.m_globalCfm != 0,
           "getSolverInfo().m_globalCfm is not 0, which softens contacts that bounce and rigid "
           "ones beyond their law: set it to 0."},
          {!(info.m_restitutionVelocityThreshold <= kBounceThreshold),
           "getSolverInfo().m_restitutionVelocityThreshold is above 0.2 m/s, so bodies with a "
           "restitution stop where they should bounce: set it to 0.2."},
      },
      advice);
}

}  // namespace

std::vector<std::string> diagnose(const btDynamicsWorld& world) {
  btContactSolverInfo info = world.getSolverInfo();
  // Bullet has no const access to the solver.
  const btConstraintSolver* const solver =
      const_cast<btDynamicsWorld&>(world).getConstraintSolver();
  if (recommendsItself(solver)) recommend(info);
  std::vector<std::string> advice;
  checkModes(info, solver, advice);
  checkNumbers(info, solver, advice);
  checkShapes(world, advice);
  return advice;
}

void recommendedSettings(btDynamicsWorld& world) {
  if (!recommendsItself(world.getConstraintSolver())) recommend(world.getSolverInfo());
}

}  // namespace cloudcontact
