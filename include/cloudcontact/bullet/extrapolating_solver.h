// ExtrapolatingSolver: Bullet's sequential impulses with faster convergence.
#pragma once

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>

#include <memory>
#include <vector>

namespace cloudcontact {

// Replaces btSequentialImpulseConstraintSolver, with the same settings and rows. After each sweep
// but the last it extrapolates from the sweeps so far (Anderson 1965), which carries weight down a
// stack, along a chain or through a light body in fewer sweeps. One solver per world.
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
