// One table of checks.
#include <BulletDynamics/ConstraintSolver/btConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDynamicsWorld.h>
#include <cloudcontact/bullet/diagnosis.h>

namespace cloudcontact {

namespace {

constexpr int kModes = SOLVER_USE_WARMSTARTING | SOLVER_USE_2_FRICTION_DIRECTIONS |
                       SOLVER_ENABLE_FRICTION_DIRECTION_CACHING;

struct Check {
  bool wrong;
  const char* advice;
};

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
