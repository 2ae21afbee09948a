// Rays with the children of compounds; drawing of clouds and patches.
#include <BulletCollision/CollisionShapes/btTriangleCallback.h>
#include <LinearMath/btIDebugDraw.h>
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/bullet/query.h>

#include <cmath>

#include "bullet/convert.h"
#include "bullet/shape_parts.h"

namespace cloudcontact {

namespace {

// Passes hits on, and names the children of compounds that Bullet leaves out: it does so only where
// a hit says nothing else of its shape.
class ChildNamer : public btCollisionWorld::RayResultCallback {
 public:
  ChildNamer(const btVector3& from, const btVector3& to,
             btCollisionWorld::RayResultCallback& callback)
      : from_(from), to_(to), callback_(callback) {
    m_flags = callback.m_flags;
    m_closestHitFraction = callback.m_closestHitFraction;
  }

  bool needsCollision(btBroadphaseProxy* proxy) const override {
    return callback_.needsCollision(proxy);
  }

  btScalar addSingleResult(btCollisionWorld::LocalRayResult& hit, bool inWorld) override {
    btCollisionWorld::LocalShapeInfo child{-1, childAt(hit)};
    if (child.m_triangleIndex >= 0) hit.m_localShapeInfo = &child;
    const btScalar result = callback_.addSingleResult(hit, inWorld);
    m_collisionObject = callback_.m_collisionObject;
    m_closestHitFraction = callback_.m_closestHitFraction;
    return result;
  }

 private:
  // The child cloud whose surface is nearest to a hit; -1: none.
  int childAt(const btCollisionWorld::LocalRayResult& hit) const {
    const btCollisionObject& object = *hit.m_collisionObject;
    if (!object.getCollisionShape()->isCompound()) return -1;
    if (hit.m_localShapeInfo && hit.m_localShapeInfo->m_shapePart >= 0) return -1;
    const btVector3 place = from_.lerp(to_, hit.m_hitFraction);
    int nearest = -1;
    double least = kNear;
    forEachPart(*object.getCollisionShape(), object.getWorldTransform(),
                [&](const btCollisionShape& part, const btTransform& at, int child) {
                  const CloudShape* const shape = CloudShape::of(part);
                  if (!shape) return;
                  const auto point = shape->shownField().at(toPose(at).toLocal(toVec3(place)));
                  if (!point) return;
                  const double voxel = shape->voxelSize();
                  if (std::abs(point->depth) >= least * voxel) return;
                  least = std::abs(point->depth) / voxel;
                  nearest = child;
                });
    return nearest;
  }

  static constexpr double kNear = 1;  // [voxels]
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
    drawer_.drawLine(c, a, color_);
    if (!normals_) return;
    const btVector3 normal = (b - a).cross(c - a);
    const btScalar length = btSqrt(normal.length());  // about a triangle's edge
    const btVector3 middle = (a + b + c) / 3;
    if (length > 0) drawer_.drawLine(middle, middle + normal / length, {1, 1, 0});
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
  forEachPart(*object.getCollisionShape(), object.getWorldTransform(),
              [&found](const btCollisionShape& part, const btTransform&, int) {
                found = found || CloudShape::of(part);
              });
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
  ChildNamer namer(from, to, callback);
  world.rayTest(from, to, namer);
}

void debugDraw(btCollisionWorld& world, btIDebugDraw& drawer) {
  btIDebugDraw* const before = world.getDebugDrawer();
  world.setDebugDrawer(&drawer);
  world.debugDrawWorld();
  world.setDebugDrawer(before);
  if (drawer.getDebugMode() & btIDebugDraw::DBG_DrawContactPoints) drawPatches(world, drawer);
}

void debugDraw(const CloudShape& shape, const btTransform& place, btIDebugDraw& drawer,
               const btVector3& color, bool normals) {
  SurfaceDrawer surface(place, drawer, color, normals);
  const btVector3 all(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
  shape.processAllTriangles(&surface, -all, all);
}

}  // namespace cloudcontact
