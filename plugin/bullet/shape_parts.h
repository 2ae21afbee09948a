// The shapes that a shape consists of.
#pragma once

#include <BulletCollision/CollisionShapes/btCompoundShape.h>

namespace cloudcontact {

// Calls visit(part, place, child) for the shape itself or, in a compound, for its children, down to
// those that are no compounds; `child` is -1 for the shape itself.
template <typename Visit>
void forEachPart(const btCollisionShape& shape, const btTransform& place, const Visit& visit,
                 int child = -1) {
  if (!shape.isCompound()) return visit(shape, place, child);
  const auto& compound = static_cast<const btCompoundShape&>(shape);
  for (int i = 0; i < compound.getNumChildShapes(); ++i)
    forEachPart(*compound.getChildShape(i), place * compound.getChildTransform(i), visit, i);
}

}  // namespace cloudcontact
