// Shapes for Bullet's own collision methods, for comparison: --method gjk, gimpact, hacd,
// primitive.
#pragma once

#include <btBulletDynamicsCommon.h>
#include <cloudcontact/law/solid.h>
#include <cloudcontact/mesh/mesh.h>

#include <memory>
#include <vector>

#include "io/options.h"

namespace cloudcontact::program {

// A Bullet shape with the data it points to (children, index arrays). Its frame is that of its mesh
// or primitive; a rigid body needs the center of mass at the origin, so move the mesh first.
struct BulletShape {
  std::vector<std::shared_ptr<void>> keep;  // outlives `shape`
  std::shared_ptr<btCollisionShape> shape;
};

// Convex hull of the vertices, for GJK and EPA. Drops inner vertices.
BulletShape hullShape(const Mesh& mesh);
// The triangles as a GImpact shape.
BulletShape gimpactShape(const Mesh& mesh);
// The triangles of a body that stands still.
BulletShape trianglesShape(const Mesh& mesh);
// Convex parts of a coarsened mesh by HACD; takes up to a minute. `concavity` is the allowed
// distance between a part and the mesh, as a share of the diagonal: smaller values give more parts.
struct ConvexParts {
  std::vector<std::vector<btVector3>> corners;  // of each part
  btScalar margin = 0;
};
ConvexParts convexParts(const Mesh& fine, double concavity = 0.01);
// A compound of the parts' hulls.
BulletShape convexPartsShape(const ConvexParts& parts);
// Bullet's own sphere, box, capsule, cylinder, cone, hull; btStaticPlaneShape for a half-space.
BulletShape primitiveShape(const Solid& shape);

// Registers algorithms that Bullet's default dispatcher lacks (GImpact).
void registerMethod(btCollisionDispatcher& dispatcher, Method method);

}  // namespace cloudcontact::program
