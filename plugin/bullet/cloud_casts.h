// What Bullet's rays and sweeps see of a cloud. Both report hits as Bullet's triangle meshes do,
// with part -1 and `index` in place of a triangle's.
#pragma once

#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <cloudcontact/field/surface_field.h>

namespace cloudcontact {

// All crossings of the field's surface, in order, with the callback's flags: a crossing from inside
// is a back face.
void castRay(const SurfaceField& field, int index, btTriangleRaycastCallback& ray);

// The triangles of the surface that a convex shape may meet (surface_tree.h), near ones first. Like
// Bullet's meshes it reports hits until one is taken that nothing can precede; unlike them it
// leaves out faces turned away. Where the surface is smooth, normals are the field's.
void castConvex(const SurfaceField& field, int index, btTriangleConvexcastCallback& sweep);

}  // namespace cloudcontact
