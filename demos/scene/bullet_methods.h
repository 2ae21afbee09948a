// Bullet's own answers, for comparison: the shapes of --method gjk, gimpact, hacd and primitive.
#pragma once

#include <btBulletDynamicsCommon.h>
#include <cloudcontact/law/solid.h>
#include <cloudcontact/mesh/mesh.h>

#include <memory>
#include <vector>

#include "io/options.h"

namespace cloudcontact::program {

// A Bullet shape and what it points into (children, index arrays), in the frame of the mesh or
// primitive it was made of: move the mesh first where Bullet wants the centre of mass at the
// origin.
struct BulletShape {
  std::vector<std::shared_ptr<void>> keep;  // outlives `shape`
  std::shared_ptr<btCollisionShape> shape;
};

// Convex hull of the vertices, which GJK and EPA see; inner vertices are dropped first.
BulletShape hullShape(const Mesh& mesh);
// The triangles as GImpact takes them.
BulletShape gimpactShape(const Mesh& mesh);
// Convex parts by HACD, of a coarsened mesh: up to a minute of work. `concavity` is how far a part
// may bulge over the mesh, as a share of the diagonal: less of it, more parts.
struct ConvexParts {
  std::vector<std::vector<btVector3>> corners;  // of each part
  btScalar margin = 0;
};
ConvexParts convexParts(const Mesh& fine, double concavity = 0.01);
// A compound of their hulls.
BulletShape convexPartsShape(const ConvexParts& parts);
// Bullet's own sphere, box, capsule, cylinder, cone, hull; btStaticPlaneShape for a half-space.
BulletShape primitiveShape(const Solid& shape);

// What the dispatcher needs for the method beyond Bullet's defaults (GImpact's algorithm).
void registerMethod(btCollisionDispatcher& dispatcher, Method method);

}  // namespace cloudcontact::program
