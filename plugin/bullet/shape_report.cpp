// Walks over objects and pairs.
#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <cloudcontact/bullet/shape_report.h>

#include "bullet/cloud_algorithm.h"

namespace cloudcontact {

namespace {

void addShapes(const btCollisionObject& object, const btCollisionShape& shape,
               std::vector<ShapeReport>& report) {
  if (shape.getShapeType() == HFFLUID_SHAPE_PROXYTYPE)
    report.push_back({&object, static_cast<const CloudShape*>(&shape)});
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

std::vector<PairReport> pairReport(const btCollisionWorld& world) {
  std::vector<PairReport> report;
  // Bullet has no const access to the pairs.
  const btBroadphasePairArray& pairs =
      const_cast<btCollisionWorld&>(world).getPairCache()->getOverlappingPairArray();
  for (int i = 0; i < pairs.size(); ++i) {
    const auto* cloud = dynamic_cast<const CloudAlgorithm*>(pairs[i].m_algorithm);
    if (!cloud) continue;
    report.push_back({static_cast<const btCollisionObject*>(pairs[i].m_pProxy0->m_clientObject),
                      static_cast<const btCollisionObject*>(pairs[i].m_pProxy1->m_clientObject),
                      cloud->answeredByShapes() ? PairPath::Shapes : PairPath::Cloud});
  }
  return report;
}

}  // namespace cloudcontact
