// Reference force between two meshes, for cases without a closed form: quadrature in double over
// distances to triangles. Shares no code with the library.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/mesh/mesh.h>

namespace cloudcontact::program::lab {

struct OracleForce {
  Vec3 force = Vec3::Zero();   // on B / stiffness of the foundation [m^3]
  Vec3 torque = Vec3::Zero();  // about the world's origin
  double deepest = 0;          // [m]
};

// Elastic foundation: every part of a surface inside the other body is pressed along its own normal
// with a pressure proportional to its depth. The mean of both bodies' surfaces. Triangles are
// subdivided until their edges are below `spacing` [m].
OracleForce foundationForce(const Mesh& a, const Mesh& b, const Pose& poseOfB, double spacing);

// Distance by which B, apart at `poseOfB`, must move along `way` (unit) until it is `depth` deep in
// A; at most `reach` [m].
double distanceUntil(const Mesh& a, const Mesh& b, const Pose& poseOfB, const Vec3& way,
                     double depth, double reach);

}  // namespace cloudcontact::program::lab
