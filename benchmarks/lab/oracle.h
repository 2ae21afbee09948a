// The true force between two meshes by quadrature in double: where no closed form is at hand.
// Shares no code with the library: depths are distances to triangles.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/mesh/mesh.h>

namespace cloudcontact::program::lab {

struct OracleForce {
  Vec3 force = Vec3::Zero();   // on B, by the foundation's stiffness [m^3]
  Vec3 torque = Vec3::Zero();  // about the world's origin
  double deepest = 0;          // [m]
};

// The elastic foundation: each body's surface, as far as it lies in the other, is pressed along its
// own normal by as much as it lies deep there; half from either body. Triangles are cut until their
// edges are below `spacing` [m].
OracleForce foundationForce(const Mesh& a, const Mesh& b, const Pose& poseOfB, double spacing);

// How far B is to be moved along `way` (unit) from where it is apart, until it lies `depth` deep.
double wayUntil(const Mesh& a, const Mesh& b, const Pose& poseOfB, const Vec3& way, double depth,
                double reach);

}  // namespace cloudcontact::program::lab
