// The spring of a pair whose bodies state no stiffness: soft under the pair's own weight, so that
// it averages the noise of the voxels' fits, and hard where much is pressed on it.
#pragma once

#include <cloudcontact/law/law.h>

namespace cloudcontact {

// The spring about where it stands: a straight line through its force, and damping ratio 1.
struct SpringTangent {
  double slope = 0;    // [N/m]
  double damping = 0;  // [N s/m]
  double offset = 0;   // [m] the depth at which the line carries nothing

  // What a backward Euler row of `step` seconds must be given as k and c at this depth, for its
  // impulse step (k (depth + step v) + c v) to be that of the line: step (slope (depth - offset +
  // step v) + damping v). Never pulls.
  KelvinVoigt row(double depth, double step) const;
};

// Its force depends on depth alone and only rises, ever steeper: nothing is gained on any way in
// and out. What it is made of, and why, stands in automatic_spring.cpp.
struct AutomaticSpring {
  double mass = 0;     // [kg] the pair's effective mass
  double soft = 0;     // [N/m] up to a depth of `even`
  double hard = 0;     // [N/m] at most, up to `deep`: what the step allows (stepLimited)
  double even = 0;     // [m]
  double reach = 0;    // [m] beyond `even`: there it would be without end, were it not for `hard`
  double deep = 0;     // [m] what is pressed in further bears far more than itself
  double last = 0;     // [m] beyond `deep`: again without end, were it not for `hardest`
  double hardest = 0;  // [N/m] at most at all; `hard` where nothing bears more than itself

  double force(double depth) const;      // [N]
  double stiffness(double depth) const;  // [N/m] the force's derivative
  double sag(double force) const;        // [m] the depth at which it carries so much
  // For a step of `step` seconds that begins at `depth` with `closing` [m/s].
  SpringTangent tangent(double depth, double closing, double step) const;
};

// `weight` [N]: the heavier body's of those that move; 0 or unknown: that of `mass` on the ground.
// `joint`: the part of a voxel that stands for one where the spring is soft (pair_law.cpp).
// `bears`: for how many times `mass` the spring may be hard where it is pressed in deep; 1 for
// Bullet's own solver (CloudContactSettings::bears).
// Throws as stepLimited does, and where voxel [m] or joint is not positive or bears is below 1.
AutomaticSpring automaticSpring(double mass, double weight, double voxel, double step,
                                double joint = 1, double bears = 1);

}  // namespace cloudcontact
