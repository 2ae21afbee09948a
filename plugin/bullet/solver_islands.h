// SolverIslands: parts what Bullet solves at once, which is one island or many, into islands that
// are solved each by itself, in an order of bodies, manifolds and joints that nothing else in the
// world changes. Bullet sorts all manifolds by island, and quicksort leaves those of one island in
// an order that depends on the others; rows that push against each other end elsewhere then. (Two
// joints of one pair of bodies, and a pair's parts of compounds, still stand as Bullet has them.)
#pragma once

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>

#include <cstdint>
#include <span>
#include <vector>

namespace cloudcontact {

class SolverIslands {
 public:
  struct Island {
    std::vector<btCollisionObject*> bodies;
    std::vector<btPersistentManifold*> manifolds;
    std::vector<btTypedConstraint*> constraints;
    bool empty() const { return manifolds.empty() && constraints.empty() && bodies.empty(); }
    void clear();
  };

  // What Bullet's solver is given.
  struct Group {
    std::span<btCollisionObject*> bodies;
    std::span<btPersistentManifold*> manifolds;
    std::span<btTypedConstraint*> constraints;
  };

  // With `cloudsOnly` islands without a cloud are in `others`. Each island is by itself; or, if not
  // `apart`, all are one, in Bullet's own order, as those in `others` are.
  void part(const Group& group, bool cloudsOnly, bool apart);

  // Those with manifolds or joints. Bodies that belong to no island, which nothing moves, are in
  // `others`: where rows need them, Bullet finds them.
  std::span<Island> joined() { return std::span(islands_).first(count_); }
  // Bodies that nothing touches.
  std::vector<btCollisionObject*> alone;
  Island others;

 private:
  void mark(int tag);
  bool isMarked(int tag) const;
  bool isJoined(int tag) const;
  Island& islandOf(int tag);
  void sort(Island& island);

  std::vector<std::uint8_t> marked_;  // by tag: has a cloud
  std::vector<int> numbers_;          // by tag: of its island, from 1
  std::vector<Island> islands_;
  std::size_t count_ = 0;
  btAlignedObjectArray<btPersistentManifold*> sorted_;
};

}  // namespace cloudcontact
