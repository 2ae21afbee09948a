// Rays and drawing for worlds with CloudShapes. Bullet's own rayTest and debugDrawWorld pass over
// them, because they switch on shape types that a new shape cannot join without harm; contactTest
// and contactPairTest need nothing of this. Sweeps (convexSweepTest) do not see clouds.
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>

class btIDebugDraw;

namespace cloudcontact {

class CloudShape;

// world.rayTest(from, to, callback), then the clouds, children of compounds included, through the
// same callback and its filters: hits are where the ray enters material, exact to 1e-3 voxel. A ray
// that starts inside a cloud meets it only after it left.
void rayTest(const btCollisionWorld& world, const btVector3& from, const btVector3& to,
             btCollisionWorld::RayResultCallback& callback);

// All clouds of the world as the drawer's mode asks: DBG_DrawWireframe their surfaces,
// DBG_DrawNormals the surfaces' normals, DBG_DrawContactPoints the outline and mean normal of each
// contact patch. Call it beside world.debugDrawWorld().
void debugDraw(btCollisionWorld& world, btIDebugDraw& drawer);

// One cloud's surface, and its normals where asked.
void debugDraw(const CloudShape& shape, const btTransform& place, btIDebugDraw& drawer,
               const btVector3& color, bool normals = false);

}  // namespace cloudcontact
