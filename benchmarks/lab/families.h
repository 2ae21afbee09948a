// The chart's marks: a method and setting over a family of cases, and which of them nothing beats.
#pragma once

#include <string>
#include <vector>

#include "lab/chart.h"

namespace cloudcontact::program::lab {

// Means over the family's cases; those that the method cannot do are not in them.
struct FamilyMark {
  std::string family, method, setting;
  double microseconds = 0, normalDeg = 0, wrench = 0;  // wrench: the larger of force and torque
  int cases = 0, cannot = 0;
  int wrong = 0;          // of `cases`: a depth is wrong (answer.h), or a touch went unseen
  double depthTimes = 0;  // the found depth by the true one, mean over the cases where it is wrong
  bool frontier = false;  // no other is faster and more accurate

  // Answers all of the family, and nothing wrongly: only such marks are on the frontier.
  bool whole() const { return cases > 0 && cannot == 0 && wrong == 0; }
};
std::vector<FamilyMark> familyMarks(const std::vector<ChartRow>& rows);
// Sets the rows' `frontier` from their families'.
void markFrontier(std::vector<ChartRow>& rows);

}  // namespace cloudcontact::program::lab
