// One method's answer held against the truth, and against itself: seen from the other body, and led
// around a closed loop.
#pragma once

#include <limits>
#include <vector>

#include "lab/cases.h"

namespace cloudcontact::program::lab {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// An answer whose depth is off by more than this share of the body's size is a wrong answer,
// however true its normal: a hull that fills a groove pushes out of the whole groove.
constexpr double kWrongDepth = 0.5;

// NaN where the truth does not say.
struct AnswerError {
  double normalDeg = 180;
  double depth = kUnknown;       // [m] of the deepest point
  double depthTimes = kUnknown;  // the deepest point's depth by the true one
  double centre = kUnknown;      // [m] from the true centre to the force's axis
  double force = kUnknown;       // of its size, relative
  double torque = kUnknown;      // about the true centre, by force and size
  bool wrongDepth = false;       // kWrongDepth
};
AnswerError errorOf(const std::vector<LabPoint>& points, const Truth& truth, double size);

// The points' force on B for a spring of 1 N/m that they share [N].
Vec3 forceOf(const std::vector<LabPoint>& points);

// What changes when A is called B and B is called A: nothing should.
struct SwapError {
  double normalDeg = kUnknown;
  double force = kUnknown;  // of its size, relative
};
// `answer` to (a, b) with B at `pose`; `swapped` is the method's pair (b, a).
SwapError swapError(const std::vector<LabPoint>& answer, const LabPair& swapped, const Pose& pose);

// The net work that the force does while B goes once around a circle of `radius` [m] through
// `pose`, towards `direction` and aside, by the work that goes back and forth; 0 for a force that
// has an energy. NaN where the bodies part on the way.
double loopWork(const LabPair& pair, const Pose& pose, const Vec3& direction, double radius,
                int steps);

}  // namespace cloudcontact::program::lab
