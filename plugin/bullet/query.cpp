// Rays and drawing of clouds.
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btTriangleCallback.h>
#include <LinearMath/btIDebugDraw.h>
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/bullet/query.h>

#include "bullet/convert.h"
#include "field/field_ray.h"

namespace cloudcontact {

namespace {

// Calls visit(cloud, place, child) for the shape itself or, in a compound, for its clouds; `child`
// is -1 for the shape itself.
template <typename Visit>
void forEachCloud(const btCollisionShape& shape, const btTransform& place, const Visit& visit,
                  int child = -1) {
  if (shape.getShapeType() == HFFLUID_SHAPE_PROXYTYPE) {
    visit(static_cast<const CloudShape&>(shape), place, child);
  } else if (shape.isCompound()) {
    const auto& compound = static_cast<const btCompoundShape&>(shape);
    for (int i = 0; i < compound.getNumChildShapes(); ++i)
      forEachCloud(*compound.getChildShape(i), place * compound.getChildTransform(i), visit, i);
  }
}

// The broad phase calls process() for every object whose box the ray crosses.
class CloudRay : public btBroadphaseRayCallback {
 public:
  CloudRay(const btVector3& from, const btVector3& to,
           btCollisionWorld::RayResultCallback& callback)
      : from_(from), to_(to), callback_(callback) {
    const btVector3 direction = (to - from).normalized();
    for (int axis = 0; axis < 3; ++axis) {
      m_rayDirectionInverse[axis] =
          direction[axis] == 0 ? btScalar(BT_LARGE_FLOAT) : 1 / direction[axis];
      m_signs[axis] = m_rayDirectionInverse[axis] < 0;
    }
    m_lambda_max = direction.dot(to - from);
  }

  bool process(const btBroadphaseProxy* proxy) override {
    if (callback_.m_closestHitFraction <= 0) return false;
    auto* const object = static_cast<btCollisionObject*>(proxy->m_clientObject);
    if (!callback_.needsCollision(object->getBroadphaseHandle())) return true;
    forEachCloud(*object->getCollisionShape(), object->getWorldTransform(),
                 [&](const CloudShape& shape, const btTransform& place, int child) {
                   test(*object, shape, place, child);
                 });
    return true;
  }

 private:
  void test(const btCollisionObject& object, const CloudShape& shape, const btTransform& place,
            int child) {
    const Pose pose = toPose(place);
    const auto hit = firstEntry(shape.field(), pose.toLocal(toVec3(from_)),
                                pose.toLocal(toVec3(to_)), callback_.m_closestHitFraction);
    if (!hit) return;
    btCollisionWorld::LocalShapeInfo info{-1, child};  // as Bullet reports a compound's child
    btCollisionWorld::LocalRayResult result(&object, child < 0 ? nullptr : &info,
                                            toBullet(Vec3(pose.orientation * hit->normal)),
                                            static_cast<btScalar>(hit->fraction));
    callback_.addSingleResult(result, true);
  }

  btVector3 from_, to_;
  btCollisionWorld::RayResultCallback& callback_;
};

class SurfaceDrawer : public btTriangleCallback {
 public:
  SurfaceDrawer(const btTransform& place, btIDebugDraw& drawer, const btVector3& color,
                bool normals)
      : place_(place), drawer_(drawer), color_(color), normals_(normals) {}

  void processTriangle(btVector3* corners, int, int) override {
    const btVector3 a = place_ * corners[0], b = place_ * corners[1], c = place_ * corners[2];
    drawer_.drawLine(a, b, color_);
    drawer_.drawLine(b, c, color_);
    if (!normals_) return;
    const btVector3 normal = (b - a).cross(c - a);
    const btScalar length = btSqrt(normal.length());  // about a square's edge
    if (length > 0) drawer_.drawLine((a + c) / 2, (a + c) / 2 + normal / length, {1, 1, 0});
  }

 private:
  btTransform place_;
  btIDebugDraw& drawer_;
  btVector3 color_;
  bool normals_;
};

// The outline of a patch's points, and their mean normal, as long as the outline.
void drawPatch(const btPersistentManifold& manifold, btIDebugDraw& drawer) {
  const btVector3 color(1, 0, 1);
  const int count = manifold.getNumContacts();
  btVector3 middle(0, 0, 0), normal(0, 0, 0);
  btScalar length = 0;
  for (int i = 0; i < count; ++i) {
    const btManifoldPoint& point = manifold.getContactPoint(i);
    const btVector3& other = manifold.getContactPoint((i + 1) % count).m_positionWorldOnB;
    drawer.drawLine(point.m_positionWorldOnB, other, color);
    length += (other - point.m_positionWorldOnB).length();
    middle += point.m_positionWorldOnB / btScalar(count);
    normal += point.m_normalWorldOnB;
  }
  if (normal.length2() > 0) drawer.drawLine(middle, middle + normal.normalized() * length, color);
}

bool holdsCloud(const btCollisionObject& object) {
  bool found = false;
  forEachCloud(*object.getCollisionShape(), object.getWorldTransform(),
               [&found](const CloudShape&, const btTransform&, int) { found = true; });
  return found;
}

void drawPatches(btCollisionWorld& world, btIDebugDraw& drawer) {
  const btDispatcher& dispatcher = *world.getDispatcher();
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold =
        *const_cast<btDispatcher&>(dispatcher).getManifoldByIndexInternal(i);
    if (manifold.getNumContacts() > 0 &&
        (holdsCloud(*manifold.getBody0()) || holdsCloud(*manifold.getBody1())))
      drawPatch(manifold, drawer);
  }
}

}  // namespace

void rayTest(const btCollisionWorld& world, const btVector3& from, const btVector3& to,
             btCollisionWorld::RayResultCallback& callback) {
  world.rayTest(from, to, callback);
  if ((to - from).fuzzyZero()) return;
  CloudRay ray(from, to, callback);
  const_cast<btBroadphaseInterface*>(world.getBroadphase())->rayTest(from, to, ray);
}

void debugDraw(const CloudShape& shape, const btTransform& place, btIDebugDraw& drawer,
               const btVector3& color, bool normals) {
  SurfaceDrawer surface(place, drawer, color, normals);
  const btVector3 all(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
  shape.processAllTriangles(&surface, -all, all);
}

void debugDraw(btCollisionWorld& world, btIDebugDraw& drawer) {
  const int mode = drawer.getDebugMode();
  const bool normals = mode & btIDebugDraw::DBG_DrawNormals;
  if (normals || (mode & btIDebugDraw::DBG_DrawWireframe)) {
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i)
      forEachCloud(*objects[i]->getCollisionShape(), objects[i]->getWorldTransform(),
                   [&](const CloudShape& shape, const btTransform& place, int) {
                     debugDraw(shape, place, drawer, {0, 1, 0}, normals);
                   });
  }
  if (mode & btIDebugDraw::DBG_DrawContactPoints) drawPatches(world, drawer);
}

}  // namespace cloudcontact
