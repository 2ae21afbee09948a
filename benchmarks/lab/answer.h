// One method's answer compared with the truth, with the answer for the swapped pair, and around a
// closed loop of poses.
#pragma once

#include <limits>
#include <vector>

#include "lab/cases.h"

namespace cloudcontact::program::lab {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// A depth that is off by more than this share of the body's size counts as wrong, even where the
// normal is right. Example: a hull that fills a groove pushes out of the whole groove.
constexpr double kWrongDepth = 0.5;

// NaN where the truth is not known.
struct AnswerError {
  double normalDeg = 180;        // of the total force's direction
  double depth = kUnknown;       // [m] of the deepest point
  double depthTimes = kUnknown;  // depth of the deepest point / true depth
  double center = kUnknown;      // [m] from the true center to the force's axis
  double force = kUnknown;       // of the magnitude, relative
  double torque = kUnknown;      // about the true center, relative to force * size
  bool wrongDepth = false;       // see kWrongDepth
};
AnswerError errorOf(const std::vector<LabPoint>& points, const Truth& truth, double size);

// Force of the points on B, for a pair stiffness of 1 N/m that the points share [N].
Vec3 forceOf(const std::vector<LabPoint>& points);

// What changes when A and B are exchanged. A symmetric method has no such error.
struct SwapError {
  double normalDeg = kUnknown;
  double force = kUnknown;  // of the magnitude, relative
};
// `answer` is for (a, b) with B at `pose`; `swapped` is the same method's pair (b, a).
SwapError swapError(const std::vector<LabPoint>& answer, const LabPair& swapped, const Pose& pose);

// Net work / total absolute work of the force while B moves once around a circle of `radius` [m]
// through `pose`, in the plane of `direction` and a normal to it. 0 for a conservative force. NaN
// where the bodies separate on the way.
double loopWork(const LabPair& pair, const Pose& pose, const Vec3& direction, double radius,
                int steps);

}  // namespace cloudcontact::program::lab
