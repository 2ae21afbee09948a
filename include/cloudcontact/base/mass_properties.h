// Mass, center of mass and inertia of a body, or of a part of one.
#pragma once

#include <cloudcontact/base/pose.h>

namespace cloudcontact {

// Lengths and axes are those of the frame that the body is given in.
struct MassProperties {
  double volume = 0;                                  // [m^3]
  double mass = 0;                                    // [kg]
  Vec3 centerOfMass = Vec3::Zero();                   // [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // about the center of mass [kg m^2]
};

}  // namespace cloudcontact
