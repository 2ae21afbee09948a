// Newton's method between Bullet's sweeps.
//
// A sweep of sequential impulses converges slowly where a light body is between heavy ones, or
// where weight passes through many bodies. After the first sweep of an island its rows are solved
// together (NewtonRows), the impulses are given to Bullet's bodies, and the next sweep tells
// whether all rows agree; nearly always they do. So a step ends with Bullet's own result.
//
// A tower of 12 bricks on springs of 2e6 N/m at 60 Hz falls with 10 sweeps a step and gains 70
// times its energy, falls with 300 if they stop at a residual of 3e-4 m/s, and stands if rows agree
// to 1e-4 (docs/measurements.md).
//
// Friction's rows are stiff springs with a slider (FrictionSpring): of rigid ones, eight hold three
// motions of two bodies, so that no impulses are their solution, sweeps drift, and whole heaps
// never agree. Bullet 3.24 begins each step without friction; here it begins with the last step's.
#include <cloudcontact/bullet/newton_solver.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "bullet/newton_rows.h"
#include "bullet/point_friction.h"
#include "bullet/solver_islands.h"
#include "bullet/solver_settings.h"

namespace cloudcontact {

namespace {

// Sweeps within which the largest residual has to fall by this factor (of the squares), or else the
// island is left as it is.
constexpr int kPatience = 5;
constexpr double kProgress = 0.5;
// Of the tolerance, what Newton's steps may leave.
constexpr double kShare = 0.5;

}  // namespace

struct NewtonSolver::State {
  NewtonRows rows;
  double goal = 0;  // of the square of the largest residual, by the sweep `until`
  int until = 0;
  std::size_t sweeps = 0, islands = 0;
  bool plain = false;  // the island that is solved now is left to Bullet's own sweeps
  SolverIslands parted;

  bool stalls(int iteration, double left);
};

bool NewtonSolver::State::stalls(int iteration, double left) {
  if (iteration > 0 && left > goal) return iteration >= until;
  goal = kProgress * left;
  until = iteration + kPatience;
  return false;
}

NewtonSolver::NewtonSolver() : state_(std::make_unique<State>()) {}
NewtonSolver::~NewtonSolver() = default;

// Joints, contacts, friction, rolling friction: friction's limits depend on the contacts.
template <typename Function>
void NewtonSolver::forEachRow(Function f) {
  std::size_t index = 0;
  for (auto* pool : {&m_tmpSolverNonContactConstraintPool, &m_tmpSolverContactConstraintPool,
                     &m_tmpSolverContactFrictionConstraintPool,
                     &m_tmpSolverContactRollingFrictionConstraintPool})
    for (int i = 0; i < pool->size(); ++i) f((*pool)[i], index++);
}

void NewtonSolver::moveTo(const std::vector<double>& impulses) {
  const btSolverConstraint* const friction = m_tmpSolverContactFrictionConstraintPool.size() > 0
                                                 ? &m_tmpSolverContactFrictionConstraintPool[0]
                                                 : nullptr;
  const auto frictions = static_cast<std::size_t>(m_tmpSolverContactFrictionConstraintPool.size());
  forEachRow([&](btSolverConstraint& row, std::size_t i) {
    btScalar low = row.m_lowerLimit, high = row.m_upperLimit;
    if (friction && &row >= friction && &row < friction + frictions) {
      high = row.m_friction *
             btScalar(m_tmpSolverContactConstraintPool[row.m_frictionIndex].m_appliedImpulse);
      low = -high;
    }
    add(row, std::clamp(static_cast<btScalar>(impulses[i]), low, high));
  });
}

// Gives a row this impulse.
void NewtonSolver::add(btSolverConstraint& row, btScalar impulse) {
  const btScalar change = impulse - btScalar(row.m_appliedImpulse);
  if (change == 0) return;
  row.m_appliedImpulse = impulse;
  btSolverBody& a = m_tmpSolverBodyPool[row.m_solverBodyIdA];
  btSolverBody& b = m_tmpSolverBodyPool[row.m_solverBodyIdB];
  a.internalApplyImpulse(row.m_contactNormal1 * a.internalGetInvMass(), row.m_angularComponentA,
                         change);
  b.internalApplyImpulse(row.m_contactNormal2 * b.internalGetInvMass(), row.m_angularComponentB,
                         change);
}

namespace {

// Of a row with the softness m_cfm Bullet takes the whole step of a stiff row less what the
// softness holds back, D (b - u) - m_cfm x. With m_cfm above 1, which is a spring softer than a
// step times the mass that it moves, that diverges. The step over 1 + m_cfm has the same end, and a
// row alone is there after one.
void soften(btSolverConstraint& row) {
  const btScalar part = 1 / (1 + row.m_cfm);
  row.m_jacDiagABInv *= part;
  row.m_rhs *= part;
  row.m_cfm *= part;
}

double inverseMassOf(const btSolverBody& body) {
  return body.m_originalBody ? double(body.m_originalBody->getInvMass()) : 0;
}

}  // namespace

void NewtonSolver::convertJoints(btTypedConstraint** constraints, int constraintCount,
                                 const btContactSolverInfo& info) {
  btSequentialImpulseConstraintSolver::convertJoints(constraints, constraintCount, info);
  if (state_->plain) return;
  for (int i = 0; i < m_tmpSolverNonContactConstraintPool.size(); ++i) {
    btSolverConstraint& row = m_tmpSolverNonContactConstraintPool[i];
    if (row.m_cfm > 0) soften(row);
  }
}

// Friction's rows have the softness of their springs, which Bullet takes to be the same part of the
// mass in both directions, and begin with the impulses of the last step. Bullet 3.24 sets them up
// without the torque that acts on the bodies in the step: what is pulled at its top was pushed on
// by its friction.
void NewtonSolver::convertContacts(btPersistentManifold** manifolds, int manifoldCount,
                                   const btContactSolverInfo& info) {
  btSequentialImpulseConstraintSolver::convertContacts(manifolds, manifoldCount, info);
  if (!newton || state_->plain) return;
  for (int i = 0; i < m_tmpSolverContactFrictionConstraintPool.size(); ++i) {
    btSolverConstraint& row = m_tmpSolverContactFrictionConstraintPool[i];
    if (!(row.m_cfm > 0)) continue;
    const btSolverConstraint& contact = m_tmpSolverContactConstraintPool[row.m_frictionIndex];
    const auto& point = *static_cast<const btManifoldPoint*>(contact.m_originalContactPoint);
    const btSolverBody& a = m_tmpSolverBodyPool[row.m_solverBodyIdA];
    const btSolverBody& b = m_tmpSolverBodyPool[row.m_solverBodyIdB];
    const double mass = 1 / (inverseMassOf(a) + inverseMassOf(b));
    const FrictionSpring spring = FrictionSpring::of(point, mass, double(info.m_timeStep));
    if (!(spring.weight > 0)) continue;
    row.m_rhs -= row.m_jacDiagABInv * (row.m_relpos1CrossNormal.dot(a.m_externalTorqueImpulse) +
                                       row.m_relpos2CrossNormal.dot(b.m_externalTorqueImpulse));
    row.m_cfm = static_cast<btScalar>(double(row.m_jacDiagABInv) / spring.weight);
    soften(row);
    const btScalar most = row.m_friction * btScalar(contact.m_appliedImpulse);
    const btScalar impulse = i == contact.m_frictionIndex ? point.m_appliedImpulseLateral1
                                                          : point.m_appliedImpulseLateral2;
    if (info.m_solverMode & SOLVER_USE_WARMSTARTING) add(row, std::clamp(impulse, -most, most));
  }
}

std::size_t NewtonSolver::sweeps() const {
  return state_->sweeps;
}
std::size_t NewtonSolver::steps() const {
  return state_->rows.steps();
}
std::size_t NewtonSolver::islands() const {
  return state_->islands;
}

btScalar NewtonSolver::solveGroup(btCollisionObject** bodies, int bodyCount,
                                  btPersistentManifold** manifolds, int manifoldCount,
                                  btTypedConstraint** constraints, int constraintCount,
                                  const btContactSolverInfo& info, btIDebugDraw* drawer,
                                  btDispatcher* dispatcher) {
  if (!newton && !cloudsOnly)
    return solve(bodies, bodyCount, manifolds, manifoldCount, constraints, constraintCount, info,
                 drawer, dispatcher);
  SolverIslands& parted = state_->parted;
  const auto count = [](int n) { return static_cast<std::size_t>(n); };
  parted.part({{bodies, count(bodyCount)},
               {manifolds, count(manifoldCount)},
               {constraints, count(constraintCount)}},
              cloudsOnly, newton);
  btScalar left = 0;
  const auto solveOne = [&](SolverIslands::Island& island, const btContactSolverInfo& how) {
    if (island.empty()) return;
    left = std::max(left,
                    solve(island.bodies.data(), int(island.bodies.size()), island.manifolds.data(),
                          int(island.manifolds.size()), island.constraints.data(),
                          int(island.constraints.size()), how, drawer, dispatcher));
  };
  btContactSolverInfo own(info);
  if (cloudsOnly) recommend(own);
  for (SolverIslands::Island& island : parted.joined()) solveOne(island, own);
  for (btCollisionObject*& body : parted.alone)
    left = std::max(left, solve(&body, 1, nullptr, 0, nullptr, 0, own, drawer, dispatcher));
  state_->plain = true;
  if (cloudsOnly) solveOne(parted.others, info);
  state_->plain = false;
  return left;
}

// A joint's rows take m_numIterations from the settings at their setup, so it is raised for all of
// the solution.
btScalar NewtonSolver::solve(btCollisionObject** bodies, int bodyCount,
                             btPersistentManifold** manifolds, int manifoldCount,
                             btTypedConstraint** constraints, int constraintCount,
                             const btContactSolverInfo& info, btIDebugDraw* drawer,
                             btDispatcher* dispatcher) {
  btContactSolverInfo own(info);
  if (newton && !state_->plain && mostSweeps > 0) {
    own.m_numIterations = std::max(info.m_numIterations, mostSweeps);
    const auto speed = static_cast<btScalar>(tolerance) * info.m_timeStep;
    own.m_leastSquaresResidualThreshold =
        std::max(info.m_leastSquaresResidualThreshold, speed * speed);
  }
  ++state_->islands;
  return btSequentialImpulseConstraintSolver::solveGroup(bodies, bodyCount, manifolds,
                                                         manifoldCount, constraints,
                                                         constraintCount, own, drawer, dispatcher);
}

btScalar NewtonSolver::solveSingleIteration(int iteration, btCollisionObject** bodies,
                                            int bodyCount, btPersistentManifold** manifolds,
                                            int manifoldCount, btTypedConstraint** constraints,
                                            int constraintCount, const btContactSolverInfo& info,
                                            btIDebugDraw* drawer) {
  State& m = *state_;
  const bool last = !newton || m.plain || iteration >= info.m_numIterations - 1;
  const btScalar left = btSequentialImpulseConstraintSolver::solveSingleIteration(
      iteration, bodies, bodyCount, manifolds, manifoldCount, constraints, constraintCount, info,
      drawer);
  ++m.sweeps;
  if (last || left <= info.m_leastSquaresResidualThreshold) return left;
  if (mostSweeps > 0 && m.stalls(iteration, left)) return 0;  // ends Bullet's loop
  moveTo(m.rows.solve(
      {m_tmpSolverNonContactConstraintPool, m_tmpSolverContactConstraintPool,
       m_tmpSolverContactFrictionConstraintPool, m_tmpSolverContactRollingFrictionConstraintPool},
      m_tmpSolverBodyPool, kShare * tolerance * double(info.m_timeStep)));
  return m.rows.agree() ? left : 0;  // 0 ends Bullet's loop
}

}  // namespace cloudcontact
