// Islands by Bullet's tags.
#include "bullet/cloud_islands.h"

#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <cloudcontact/bullet/cloud_shape.h>

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
int islandOf(const btCollisionObject& a, const btCollisionObject& b) {
  return a.getIslandTag() >= 0 ? a.getIslandTag() : b.getIslandTag();
}

}  // namespace

void CloudIslands::Part::clear() {
  bodies.clear();
  manifolds.clear();
  constraints.clear();
}

bool CloudIslands::isMarked(int island) const {
  return island >= 0 && std::size_t(island) < marked_.size() && marked_[std::size_t(island)];
}

void CloudIslands::mark(int island) {
  if (island < 0) return;
  if (marked_.size() <= std::size_t(island)) marked_.resize(std::size_t(island) + 1, 0);
  marked_[std::size_t(island)] = 1;
}

void CloudIslands::part(btCollisionObject** bodies, int bodyCount, btPersistentManifold** manifolds,
                        int manifoldCount, btTypedConstraint** constraints, int constraintCount) {
  marked_.clear();
  clouds.clear();
  others.clear();
  for (int i = 0; i < bodyCount; ++i)
    if (hasCloud(*bodies[i])) mark(bodies[i]->getIslandTag());
  for (int i = 0; i < manifoldCount; ++i) {
    const btCollisionObject &a = *manifolds[i]->getBody0(), &b = *manifolds[i]->getBody1();
    if (!isMarked(islandOf(a, b)) && (hasCloud(a) || hasCloud(b))) mark(islandOf(a, b));
  }
  for (int i = 0; i < bodyCount; ++i) {
    const int island = bodies[i]->getIslandTag();
    if (island < 0 || isMarked(island)) clouds.bodies.push_back(bodies[i]);
    if (!isMarked(island)) others.bodies.push_back(bodies[i]);
  }
  for (int i = 0; i < manifoldCount; ++i) {
    const int island = islandOf(*manifolds[i]->getBody0(), *manifolds[i]->getBody1());
    (isMarked(island) ? clouds : others).manifolds.push_back(manifolds[i]);
  }
  for (int i = 0; i < constraintCount; ++i) {
    const int island = islandOf(constraints[i]->getRigidBodyA(), constraints[i]->getRigidBodyB());
    (isMarked(island) ? clouds : others).constraints.push_back(constraints[i]);
  }
}

}  // namespace cloudcontact
