// NewtonSolver: Bullet's rows, solved until they agree.
#pragma once

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>

#include <cstddef>
#include <memory>
#include <vector>

namespace cloudcontact {

// Replaces btSequentialImpulseConstraintSolver, with the same settings and rows. Joints' soft rows
// (m_cfm) converge, which those softer than their bodies do not in Bullet. After a sweep the rows
// of an island are solved together by Newton's method, and the next sweep tells whether they agree:
// ten sweeps leave stiff contacts apart, and a tower that rocks on what is left gains energy
// (docs/engine.md, "The solver"). One solver per world.
class NewtonSolver : public btSequentialImpulseConstraintSolver {
 public:
  NewtonSolver();
  ~NewtonSolver() override;

  bool newton = true;  // false: Bullet's own sweeps, to the bit
  // [m/s^2] An island is solved once a sweep changes no row's velocity by more than this in a
  // second: times the step, it is a speed. Finite and positive.
  double tolerance = 2e-3;
  // Sweeps of an island and step beyond which it is left as it is; fewer where 5 sweeps get it no
  // nearer, and none after friction that jams the bodies: it is then less than Coulomb's law
  // allows, but gains no energy. getSolverInfo().m_numIterations counts where it is more; with
  // `mostSweeps` 0 it counts alone, as in Bullet.
  int mostSweeps = 300;
  // Islands with a cloud are solved with what recommendedSettings() sets, whatever the world's
  // settings are. Islands without one are solved as by btSequentialImpulseConstraintSolver with the
  // world's settings: Bullet's own shapes move as in a world without clouds, to the bit.
  // recommendedSettings() then leaves the world's settings alone.
  bool cloudsOnly = false;

  // Sweeps of all islands and steps so far, Newton's steps, and islands solved.
  std::size_t sweeps() const;
  std::size_t steps() const;
  std::size_t islands() const;

  btScalar solveGroup(btCollisionObject** bodies, int bodyCount, btPersistentManifold** manifolds,
                      int manifoldCount, btTypedConstraint** constraints, int constraintCount,
                      const btContactSolverInfo& info, btIDebugDraw* drawer,
                      btDispatcher* dispatcher) override;

 protected:
  void convertJoints(btTypedConstraint** constraints, int constraintCount,
                     const btContactSolverInfo& info) override;
  void convertContacts(btPersistentManifold** manifolds, int manifoldCount,
                       const btContactSolverInfo& info) override;
  btScalar solveSingleIteration(int iteration, btCollisionObject** bodies, int bodyCount,
                                btPersistentManifold** manifolds, int manifoldCount,
                                btTypedConstraint** constraints, int constraintCount,
                                const btContactSolverInfo& info, btIDebugDraw* drawer) override;

 private:
  struct State;

  btScalar solve(btCollisionObject** bodies, int bodyCount, btPersistentManifold** manifolds,
                 int manifoldCount, btTypedConstraint** constraints, int constraintCount,
                 const btContactSolverInfo& info, btIDebugDraw* drawer, btDispatcher* dispatcher);
  template <typename Function>
  void forEachRow(Function f);
  void moveTo(const std::vector<double>& impulses);
  void add(btSolverConstraint& row, btScalar impulse);

  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
