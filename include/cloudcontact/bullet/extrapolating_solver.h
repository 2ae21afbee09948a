// ExtrapolatingSolver: Bullet's sequential impulses, nearer to their solution in as many sweeps.
#pragma once

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>

#include <memory>
#include <vector>

namespace cloudcontact {

// Takes the place of btSequentialImpulseConstraintSolver, with the same settings and the same rows:
// after each sweep but the last it steps further the way that the sweeps so far have gone, which
// carries weight down a stack, along a chain or through a light body in fewer of them. What it does
// and why stands in extrapolating_solver.cpp. One world each; keeps its memory between steps.
class ExtrapolatingSolver : public btSequentialImpulseConstraintSolver {
 public:
  ExtrapolatingSolver();
  ~ExtrapolatingSolver() override;

  bool extrapolates = true;  // false: Bullet's own sweeps, to the bit

 protected:
  btScalar solveSingleIteration(int iteration, btCollisionObject** bodies, int bodyCount,
                                btPersistentManifold** manifolds, int manifoldCount,
                                btTypedConstraint** constraints, int constraintCount,
                                const btContactSolverInfo& info, btIDebugDraw* drawer) override;

 private:
  struct State;

  template <typename Function>
  void forEachRow(Function f);
  void begin();
  void read(std::vector<double>& impulses);
  void moveTo(const std::vector<double>& impulses);

  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
