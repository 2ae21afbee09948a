// CloudIslands: parts what Bullet solves at once, which is one island or many, into those islands
// where a cloud is and the others. Order stays, so each part's rows are solved as they were beside
// the other's.
#pragma once

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>

#include <cstdint>
#include <vector>

namespace cloudcontact {

class CloudIslands {
 public:
  struct Part {
    std::vector<btCollisionObject*> bodies;
    std::vector<btPersistentManifold*> manifolds;
    std::vector<btTypedConstraint*> constraints;
    bool empty() const { return manifolds.empty() && constraints.empty() && bodies.empty(); }
    void clear();
  };

  // Fills both parts. Bodies that belong to no island, which nothing moves, are in both.
  void part(btCollisionObject** bodies, int bodyCount, btPersistentManifold** manifolds,
            int manifoldCount, btTypedConstraint** constraints, int constraintCount);

  Part clouds, others;

 private:
  bool isMarked(int island) const;
  void mark(int island);

  std::vector<std::uint8_t> marked_;  // by island
};

}  // namespace cloudcontact
