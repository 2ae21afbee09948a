// Mass, center of mass and inertia of a body, or of a part of one; and the axes in which an inertia
// is diagonal.
#pragma once

#include <cloudcontact/base/pose.h>

#include <vector>

namespace cloudcontact {

// Lengths and axes are those of the frame that the body is given in.
struct MassProperties {
  double volume = 0;                                  // [m^3]
  double mass = 0;                                    // [kg]
  Vec3 centerOfMass = Vec3::Zero();                   // [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // about the center of mass [kg m^2]
};

// Of a body at `place`, in the frame of the place.
MassProperties placed(const MassProperties& body, const Pose& place);
// Of several parts of one body, in one frame. Their mass must not be 0.
MassProperties sumOf(const std::vector<MassProperties>& parts);

// Axes in which an inertia has no products.
struct PrincipalAxes {
  Eigen::Quaterniond orientation;  // in the frame of the inertia
  Vec3 moments;                    // about these axes [kg m^2]
};

// The axes in the order and direction nearest to those of `near`. Products of inertia in the axes
// of `near` up to `enough` of the largest moment count as none: then the axes are those of `near`.
PrincipalAxes principalAxes(const Eigen::Matrix3d& inertia,
                            const Eigen::Quaterniond& near = Eigen::Quaterniond::Identity(),
                            double enough = 0);

// Products below this share of the largest moment turn the axes by less than the voxels of a body
// can tell: its faces stay along the voxels.
constexpr double kDiagonalEnough = 1e-3;

}  // namespace cloudcontact
