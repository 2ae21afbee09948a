// Walks over objects.
#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <cloudcontact/bullet/shape_report.h>

namespace cloudcontact {

namespace {

void addShapes(const btCollisionObject& object, const btCollisionShape& shape,
               std::vector<ShapeReport>& report) {
  if (const CloudShape* const cloud = CloudShape::of(shape)) report.push_back({&object, cloud});
  if (!shape.isCompound()) return;
  const auto& compound = static_cast<const btCompoundShape&>(shape);
  for (int i = 0; i < compound.getNumChildShapes(); ++i)
    addShapes(object, *compound.getChildShape(i), report);
}

}  // namespace

std::vector<ShapeReport> shapeReport(const btCollisionWorld& world) {
  std::vector<ShapeReport> report;
  const btCollisionObjectArray& objects = world.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i)
    addShapes(*objects[i], *objects[i]->getCollisionShape(), report);
  return report;
}

}  // namespace cloudcontact
