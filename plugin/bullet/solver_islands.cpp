// Islands by Bullet's tags.
#include "bullet/solver_islands.h"

#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <cloudcontact/bullet/cloud_shape.h>

#include <algorithm>
#include <tuple>

namespace cloudcontact {

namespace {

bool hasCloud(const btCollisionShape& shape) {
  if (!shape.isCompound()) return CloudShape::of(shape) != nullptr;
  const auto& compound = static_cast<const btCompoundShape&>(shape);
  for (int i = 0; i < compound.getNumChildShapes(); ++i)
    if (hasCloud(*compound.getChildShape(i))) return true;
  return false;
}

bool hasCloud(const btCollisionObject& object) {
  return hasCloud(*object.getCollisionShape());
}

// Of two bodies that are joined; negative where neither moves.
int tagOf(const btCollisionObject& a, const btCollisionObject& b) {
  return a.getIslandTag() >= 0 ? a.getIslandTag() : b.getIslandTag();
}
int tagOf(const btPersistentManifold& manifold) {
  return tagOf(*manifold.getBody0(), *manifold.getBody1());
}
int tagOf(const btTypedConstraint& joint) {
  return tagOf(joint.getRigidBodyA(), joint.getRigidBodyB());
}

// Bodies by their places in the world; a pair's manifolds by its patches (ManifoldWriter), and
// those of several parts of a compound as the dispatcher has them.
auto placeOf(const btPersistentManifold& m) {
  return std::make_tuple(m.getBody0()->getWorldArrayIndex(), m.getBody1()->getWorldArrayIndex(),
                         m.m_companionIdA, m.m_index1a);
}
auto placeOf(const btTypedConstraint& joint) {
  return std::make_tuple(joint.getRigidBodyA().getWorldArrayIndex(),
                         joint.getRigidBodyB().getWorldArrayIndex());
}

}  // namespace

void SolverIslands::Island::clear() {
  bodies.clear();
  manifolds.clear();
  constraints.clear();
}

bool SolverIslands::isMarked(int tag) const {
  return tag >= 0 && std::size_t(tag) < marked_.size() && marked_[std::size_t(tag)];
}

void SolverIslands::mark(int tag) {
  if (tag < 0) return;
  if (marked_.size() <= std::size_t(tag)) marked_.resize(std::size_t(tag) + 1, 0);
  marked_[std::size_t(tag)] = 1;
}

bool SolverIslands::isJoined(int tag) const {
  return std::size_t(tag) < numbers_.size() && numbers_[std::size_t(tag)] > 0;
}

SolverIslands::Island& SolverIslands::islandOf(int tag) {
  if (numbers_.size() <= std::size_t(tag)) numbers_.resize(std::size_t(tag) + 1, 0);
  int& number = numbers_[std::size_t(tag)];
  if (number == 0) {
    number = static_cast<int>(++count_);
    if (islands_.size() < count_) islands_.emplace_back();
    islands_[count_ - 1].clear();
  }
  return islands_[static_cast<std::size_t>(number) - 1];
}

// Joints of equal bodies stay in Bullet's order. Manifolds end in the one in which its quicksort
// leaves equal ones, as it has them where the island is all there is in the world.
void SolverIslands::sort(Island& island) {
  std::sort(island.bodies.begin(), island.bodies.end(), [](const auto* a, const auto* b) {
    return a->getWorldArrayIndex() < b->getWorldArrayIndex();
  });
  std::sort(island.manifolds.begin(), island.manifolds.end(),
            [](const auto* a, const auto* b) { return placeOf(*a) < placeOf(*b); });
  sorted_.resizeNoInitialize(static_cast<int>(island.manifolds.size()));
  for (int i = 0; i < sorted_.size(); ++i) sorted_[i] = island.manifolds[std::size_t(i)];
  if (sorted_.size() > 1) sorted_.quickSort([](const auto*, const auto*) { return false; });
  for (int i = 0; i < sorted_.size(); ++i) island.manifolds[std::size_t(i)] = sorted_[i];
  std::stable_sort(island.constraints.begin(), island.constraints.end(),
                   [](const auto* a, const auto* b) { return placeOf(*a) < placeOf(*b); });
}

void SolverIslands::part(const Group& group, bool cloudsOnly, bool apart) {
  marked_.clear();
  numbers_.clear();
  count_ = 0;
  alone.clear();
  others.clear();
  for (const btCollisionObject* body : group.bodies)
    if (!cloudsOnly || hasCloud(*body)) mark(body->getIslandTag());
  for (const btPersistentManifold* m : group.manifolds)
    if (!cloudsOnly || hasCloud(*m->getBody0()) || hasCloud(*m->getBody1())) mark(tagOf(*m));
  const auto home = [&](int tag) -> Island& {
    return isMarked(tag) ? islandOf(apart ? tag : 0) : others;
  };
  for (btPersistentManifold* m : group.manifolds) home(tagOf(*m)).manifolds.push_back(m);
  for (btTypedConstraint* joint : group.constraints)
    home(tagOf(*joint)).constraints.push_back(joint);
  for (btCollisionObject* body : group.bodies) {
    const int tag = body->getIslandTag();
    if (!isMarked(tag) || isJoined(apart ? tag : 0))
      home(tag).bodies.push_back(body);
    else
      alone.push_back(body);
  }
  if (!apart) return;
  for (Island& island : joined()) sort(island);
}

}  // namespace cloudcontact
