// More than Bullet's queries tell of clouds. All of these see CloudShapes as they are: rayTest,
// convexSweepTest, contactTest, contactPairTest, ghosts and debugDrawWorld (docs/bullet.md).
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>

class btIDebugDraw;

namespace cloudcontact {

class CloudShape;

// As world.rayTest(), and hits on the clouds of a compound name the child: m_shapePart -1,
// m_triangleIndex the child's index. Bullet's own name it by CloudShape::setUserIndex().
void rayTest(const btCollisionWorld& world, const btVector3& from, const btVector3& to,
             btCollisionWorld::RayResultCallback& callback);

// As world.debugDrawWorld() with this drawer, and the outline and mean normal of each contact patch
// of clouds (DBG_DrawContactPoints).
void debugDraw(btCollisionWorld& world, btIDebugDraw& drawer);

// Draws one cloud's surface, with normals of about a voxel's length if `normals` is true.
void debugDraw(const CloudShape& shape, const btTransform& place, btIDebugDraw& drawer,
               const btVector3& color, bool normals = false);

}  // namespace cloudcontact
