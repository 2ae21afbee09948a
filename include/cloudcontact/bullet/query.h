// Rays and drawing for worlds with CloudShapes, which Bullet's own rayTest and debugDrawWorld skip.
// contactTest and contactPairTest work as they are. Sweeps (convexSweepTest) do not see clouds.
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>

class btIDebugDraw;

namespace cloudcontact {

class CloudShape;

// Calls world.rayTest(from, to, callback) and then tests the clouds, children of compounds
// included, with the same callback and its filters. A hit is where the ray enters material, exact
// to 1e-3 voxel. A ray that starts inside a cloud must leave it before it can hit it.
void rayTest(const btCollisionWorld& world, const btVector3& from, const btVector3& to,
             btCollisionWorld::RayResultCallback& callback);

// Draws all clouds of the world by the drawer's mode: surfaces (DBG_DrawWireframe), normals
// (DBG_DrawNormals), and the outline and mean normal of each contact patch (DBG_DrawContactPoints).
// Call it in addition to world.debugDrawWorld().
void debugDraw(btCollisionWorld& world, btIDebugDraw& drawer);

// Draws one cloud's surface, with normals if `normals` is true.
void debugDraw(const CloudShape& shape, const btTransform& place, btIDebugDraw& drawer,
               const btVector3& color, bool normals = false);

}  // namespace cloudcontact
