// Anderson acceleration of Bullet's sweeps.
//
// A sweep of sequential impulses is a map x -> g(x) of all rows' impulses, and the solution is its
// fixed point. Convergence is slow where a light body is between heavy ones, or where weight passes
// through many bodies.
//
// The residuals r = g(x) - x of the last few sweeps are combined to the smallest possible one, and
// the next sweep starts at the same combination of their results (Anderson 1965; for linear rows it
// is GMRES with the sweep as preconditioner). Residuals are measured in energy, r^2 times the row's
// inverse mass; otherwise rows of heavy bodies would outweigh those of light ones.
//
// Rows have limits, so the map has kinks. The combination is clamped to the limits, those of
// friction by the new normal impulse. Where a residual grew, the history belongs to other active
// limits and is dropped. The last sweep is not extrapolated, so a step ends with Bullet's own
// result.
//
// A tower of 12 bricks on springs of 2e6 N/m at 60 Hz falls with 10 sweeps a step and gains 70
// times its energy, falls with 300 if they stop at a residual of 3e-4 m/s, and stands with 18 in
// the mean if they stop at 1e-4 (docs/measurements.md). A hundredth of that takes two sweeps more.
#include <cloudcontact/bullet/extrapolating_solver.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "bullet/cloud_islands.h"
#include "bullet/solver_settings.h"

namespace cloudcontact {

namespace {

// The number of differences of residuals that are combined.
constexpr int kDepth = 5;
// A residual below this fraction of the impulses is rounding.
constexpr double kRounding = sizeof(btScalar) == 4 ? 1e-12 : 1e-26;  // of the squares
// Regularization, for differences that are nearly parallel.
constexpr double kRegular = sizeof(btScalar) == 4 ? 1e-8 : 1e-12;
// A residual that grew by more than this (of the squares) belongs to other active limits.
constexpr double kGrown = 1.0;

// Sweeps within which the largest residual has to fall by this factor (of the squares), or else the
// island is left as it is: piles in which much slides never agree.
constexpr int kPatience = 20;
constexpr double kProgress = 0.5;

using Column = std::vector<double>;

}  // namespace

struct ExtrapolatingSolver::State {
  Column weight, start, result, residual, lastResult, lastResidual, next;
  std::array<Column, kDepth> residuals, results;  // differences, the oldest overwritten
  int kept = 0, oldest = 0;
  double last = 0;  // square of the last residual
  double goal = 0;  // of the square of the largest residual, by the sweep `until`
  int until = 0;
  std::size_t sweeps = 0, islands = 0;
  bool plain = false;   // the island that is solved now is left to Bullet's own sweeps
  CloudIslands parted;  // with cloudsOnly

  void fit(std::size_t rows) {
    for (Column* c : {&weight, &start, &result, &residual, &lastResult, &lastResidual, &next})
      c->resize(rows);
    for (auto* set : {&residuals, &results})
      for (Column& c : *set) c.resize(rows);
  }
  void forget() { kept = oldest = 0; }
  double dot(const Column& a, const Column& b) const {
    double sum = 0;
    for (std::size_t i = 0; i < weight.size(); ++i) sum += weight[i] * a[i] * b[i];
    return sum;
  }
  void remember();
  bool combine();
  bool stalls(int iteration, double left);
};

bool ExtrapolatingSolver::State::stalls(int iteration, double left) {
  if (iteration > 0 && left > goal) return iteration >= until;
  goal = kProgress * left;
  until = iteration + kPatience;
  return false;
}

// Stores the differences of this sweep's residual and result from the last one's.
void ExtrapolatingSolver::State::remember() {
  const int at = kept < kDepth ? kept++ : std::exchange(oldest, (oldest + 1) % kDepth);
  for (std::size_t i = 0; i < weight.size(); ++i) {
    residuals[at][i] = residual[i] - lastResidual[i];
    results[at][i] = result[i] - lastResult[i];
  }
}

// The combination with the smallest residual, from the normal equations of at most kDepth unknowns,
// by Cholesky's decomposition in place.
bool ExtrapolatingSolver::State::combine() {
  double a[kDepth][kDepth], b[kDepth], most = 0;
  for (int i = 0; i < kept; ++i) {
    for (int j = 0; j <= i; ++j) a[i][j] = dot(residuals[i], residuals[j]);
    b[i] = dot(residuals[i], residual);
    most = std::max(most, a[i][i]);
  }
  if (!(most > 0)) return false;
  for (int i = 0; i < kept; ++i) {
    a[i][i] += kRegular * most;
    for (int j = 0; j <= i; ++j) {
      for (int k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k];
      if (i == j) {
        if (!(a[i][i] > 0)) return false;
        a[i][i] = std::sqrt(a[i][i]);
      } else {
        a[i][j] /= a[j][j];
      }
    }
  }
  for (int i = 0; i < kept; ++i) {
    for (int k = 0; k < i; ++k) b[i] -= a[i][k] * b[k];
    b[i] /= a[i][i];
  }
  for (int i = kept - 1; i >= 0; --i) {
    for (int k = i + 1; k < kept; ++k) b[i] -= a[k][i] * b[k];
    b[i] /= a[i][i];
  }
  next = result;
  for (int j = 0; j < kept; ++j)
    for (std::size_t i = 0; i < next.size(); ++i) next[i] -= b[j] * results[j][i];
  return true;
}

ExtrapolatingSolver::ExtrapolatingSolver() : state_(std::make_unique<State>()) {}
ExtrapolatingSolver::~ExtrapolatingSolver() = default;

// Joints, contacts, friction, rolling friction: friction's limits depend on the contacts.
template <typename Function>
void ExtrapolatingSolver::forEachRow(Function f) {
  std::size_t index = 0;
  for (auto* pool : {&m_tmpSolverNonContactConstraintPool, &m_tmpSolverContactConstraintPool,
                     &m_tmpSolverContactFrictionConstraintPool,
                     &m_tmpSolverContactRollingFrictionConstraintPool})
    for (int i = 0; i < pool->size(); ++i) f((*pool)[i], index++);
}

void ExtrapolatingSolver::begin() {
  State& m = *state_;
  m.forget();
  std::size_t rows = 0;
  forEachRow([&](const btSolverConstraint&, std::size_t) { ++rows; });
  m.fit(rows);
  forEachRow([&](const btSolverConstraint& row, std::size_t i) {
    m.weight[i] = row.m_jacDiagABInv > 0 ? 1 / static_cast<double>(row.m_jacDiagABInv) : 0;
  });
}

void ExtrapolatingSolver::read(std::vector<double>& impulses) {
  forEachRow([&](const btSolverConstraint& row, std::size_t i) {
    impulses[i] = static_cast<double>(btScalar(row.m_appliedImpulse));
  });
}

void ExtrapolatingSolver::moveTo(const std::vector<double>& impulses) {
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
    const btScalar before = row.m_appliedImpulse;
    const btScalar after = std::clamp(static_cast<btScalar>(impulses[i]), low, high);
    if (after == before) return;
    row.m_appliedImpulse = after;
    btSolverBody& a = m_tmpSolverBodyPool[row.m_solverBodyIdA];
    btSolverBody& b = m_tmpSolverBodyPool[row.m_solverBodyIdB];
    a.internalApplyImpulse(row.m_contactNormal1 * a.internalGetInvMass(), row.m_angularComponentA,
                           after - before);
    b.internalApplyImpulse(row.m_contactNormal2 * b.internalGetInvMass(), row.m_angularComponentB,
                           after - before);
  });
}

// Of a joint's row with the softness m_cfm Bullet takes the whole step of a stiff row less what the
// softness holds back, D (b - u) - m_cfm x. With m_cfm above 1, which is a spring softer than a
// step times the mass that it moves, that diverges. The step over 1 + m_cfm has the same end, and a
// row alone is there after one.
void ExtrapolatingSolver::convertJoints(btTypedConstraint** constraints, int constraintCount,
                                        const btContactSolverInfo& info) {
  btSequentialImpulseConstraintSolver::convertJoints(constraints, constraintCount, info);
  if (state_->plain) return;
  for (int i = 0; i < m_tmpSolverNonContactConstraintPool.size(); ++i) {
    btSolverConstraint& row = m_tmpSolverNonContactConstraintPool[i];
    if (!(row.m_cfm > 0)) continue;
    const btScalar part = 1 / (1 + row.m_cfm);
    row.m_jacDiagABInv *= part;
    row.m_rhs *= part;
    row.m_cfm *= part;
  }
}

std::size_t ExtrapolatingSolver::sweeps() const {
  return state_->sweeps;
}
std::size_t ExtrapolatingSolver::islands() const {
  return state_->islands;
}

btScalar ExtrapolatingSolver::solveGroup(btCollisionObject** bodies, int bodyCount,
                                         btPersistentManifold** manifolds, int manifoldCount,
                                         btTypedConstraint** constraints, int constraintCount,
                                         const btContactSolverInfo& info, btIDebugDraw* drawer,
                                         btDispatcher* dispatcher) {
  if (!cloudsOnly)
    return solve(bodies, bodyCount, manifolds, manifoldCount, constraints, constraintCount, info,
                 drawer, dispatcher);
  CloudIslands& parted = state_->parted;
  parted.part(bodies, bodyCount, manifolds, manifoldCount, constraints, constraintCount);
  btScalar left = 0;
  for (CloudIslands::Part* part : {&parted.clouds, &parted.others}) {
    if (part->empty()) continue;
    btContactSolverInfo own(info);
    state_->plain = part == &parted.others;
    if (!state_->plain) recommend(own);
    left =
        std::max(left, solve(part->bodies.data(), int(part->bodies.size()), part->manifolds.data(),
                             int(part->manifolds.size()), part->constraints.data(),
                             int(part->constraints.size()), own, drawer, dispatcher));
  }
  state_->plain = false;
  return left;
}

// A joint's rows take m_numIterations from the settings at their setup, so it is raised for all of
// the solution.
btScalar ExtrapolatingSolver::solve(btCollisionObject** bodies, int bodyCount,
                                    btPersistentManifold** manifolds, int manifoldCount,
                                    btTypedConstraint** constraints, int constraintCount,
                                    const btContactSolverInfo& info, btIDebugDraw* drawer,
                                    btDispatcher* dispatcher) {
  btContactSolverInfo own(info);
  if (extrapolates && !state_->plain && mostSweeps > 0) {
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

btScalar ExtrapolatingSolver::solveSingleIteration(
    int iteration, btCollisionObject** bodies, int bodyCount, btPersistentManifold** manifolds,
    int manifoldCount, btTypedConstraint** constraints, int constraintCount,
    const btContactSolverInfo& info, btIDebugDraw* drawer) {
  State& m = *state_;
  const bool last = !extrapolates || m.plain || iteration >= info.m_numIterations - 1;
  if (!last && iteration == 0) begin();
  if (!last) read(m.start);
  const btScalar left = btSequentialImpulseConstraintSolver::solveSingleIteration(
      iteration, bodies, bodyCount, manifolds, manifoldCount, constraints, constraintCount, info,
      drawer);
  ++m.sweeps;
  if (last || left <= info.m_leastSquaresResidualThreshold) return left;
  if (mostSweeps > 0 && m.stalls(iteration, left)) return 0;  // ends Bullet's loop
  read(m.result);
  for (std::size_t i = 0; i < m.result.size(); ++i) m.residual[i] = m.result[i] - m.start[i];
  const double now = m.dot(m.residual, m.residual);
  if (iteration > 0 && now <= kGrown * m.last)
    m.remember();
  else
    m.forget();
  m.last = now;
  m.lastResult = m.result;
  m.lastResidual = m.residual;
  if (m.kept > 0 && now > kRounding * m.dot(m.result, m.result) && m.combine()) moveTo(m.next);
  return left;
}

}  // namespace cloudcontact
