// AutomaticSpring: the spring for pairs without a stated stiffness. It is soft under the pair's own
// weight, which averages out the noise of the voxel fits, and stiffens under load (docs/engine.md,
// "One spring a pair").
#pragma once

#include <cloudcontact/law/law.h>

namespace cloudcontact {

// The spring over one step: a straight line through its force, and damping ratio 1.
struct SpringTangent {
  double slope = 0;    // [N/m]
  double damping = 0;  // [N s/m]
  double offset = 0;   // [m] the depth at which the line is 0

  // The k and c of a backward Euler row of `step` seconds at this depth. Its impulse, step (k
  // (depth
  // + step v) + c v), is then that of the line, step (slope (depth - offset + step v) + damping v).
  // Never pulls.
  KelvinVoigt row(double depth, double step) const;
};

// A convex function of depth alone, so that no path in and out gains energy. automatic_spring.cpp
// explains its parts.
struct AutomaticSpring {
  double mass = 0;   // [kg] the pair's effective mass
  double soft = 0;   // [N/m] up to a depth of `even`
  double hard = 0;   // [N/m] the most: what the step allows for `bears` times the mass
  double even = 0;   // [m]
  double reach = 0;  // [m] beyond `even`, where the force has a pole unless `hard` limits it
  // Where the spring is harder than `limit` or pushes by more than `weight`, the pair bears other
  // bodies, and is damped for their mass, too.
  double limit = 0;   // [N/m] what the step allows for the mass alone (stepLimited)
  double weight = 0;  // [N] the larger of the bodies' weights

  double force(double depth) const;      // [N]
  double stiffness(double depth) const;  // [N/m] the force's derivative
  double sag(double force) const;        // [m] the depth at which it carries `force` [N]
  // For a step of `step` seconds that begins at `depth` with `closing` [m/s].
  SpringTangent tangent(double depth, double closing, double step) const;
};

// `weight` [N]: the larger of the movable bodies' weights; 0 or unknown: the weight of `mass` [kg].
// `joint`: the fraction of a voxel that counts as one where the spring is soft.
// `bears`: multiple of `mass` that the spring may be hard enough for; 1 for Bullet's own solver
// (CloudContactSettings::bears).
// Throws std::invalid_argument as stepLimited() does, if voxel [m] is not positive, if joint is not
// in (0, 1], or if bears is below 1 or not finite.
AutomaticSpring automaticSpring(double mass, double weight, double voxel, double step,
                                double joint = 1, double bears = 1);

}  // namespace cloudcontact
