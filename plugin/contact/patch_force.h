// The second half of a query, second step: from a patch's sums to its force, and to the points
// that carry it.
#pragma once

#include "bins.h"

namespace cloudcontact {

// A patch's force before the law scales it: direction and torque, in units of area times depth.
struct PatchForce {
  Vec3 force = Vec3::Zero();   // on B [m^3]
  Vec3 torque = Vec3::Zero();  // about the patch's area centre [m^4]
  Vec3 center = Vec3::Zero();  // area centre, frame body [m]
  double trustA = 0.5;         // how far A's surface, the more coherent, decides
  // How far the surfaces fall away from each other over the patch by their curvature, the mean by
  // pressed volume [m]. Of a patch that is d deep d/3 for balls, d/5 for a cylinder's side on a
  // face, 0 for faces that fit.
  double fall = 0;
  double lean = 0;  // mean cosine of A's normals to theirs in the mean, times that of B's
};

// Under the foundation law the exact gradient of the overlap's energy; under the paper's law
// without the share of walls that run along the other body (FORCE.md, "P" and "CW").
PatchForce forceOf(const Sums& patch, bool foundation, bool oneSided, Side sampled);

// Four points in the frame body that together have exactly the patch's force and torque.
struct PatchPoints {
  Vec3 position[4];
  Vec3 normal[4];    // unit, from A to B
  double weight[4];  // depth relative to the patch's mean
};
PatchPoints pointsOf(const Sums& patch, const PatchForce& force, double voxel);

}  // namespace cloudcontact
