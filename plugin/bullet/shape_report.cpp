// Walks over objects.
#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>
#include <cloudcontact/bullet/shape_report.h>

#include "bullet/shape_parts.h"

namespace cloudcontact {

std::vector<ShapeReport> shapeReport(const btCollisionWorld& world) {
  std::vector<ShapeReport> report;
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i)
    forEachPart(*objects[i]->getCollisionShape(), objects[i]->getWorldTransform(),
                [&](const btCollisionShape& part, const btTransform&, int) {
                  if (const CloudShape* const cloud = CloudShape::of(part))
                    report.push_back({objects[i], cloud});
                });
  return report;
}

}  // namespace cloudcontact
