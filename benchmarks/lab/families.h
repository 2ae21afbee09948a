// Results by family: the chart's marks, the frontier, and which method to use for what.
#pragma once

#include <string>
#include <vector>

#include "lab/chart_row.h"

namespace cloudcontact::program::lab {

// The method's name in charts and reports: "CloudContact" for "cloud".
std::string shownName(const std::string& method);

// A method at one setting: means over the cases of a family that it can do.
struct FamilyMark {
  std::string family, method, setting;
  double microseconds = 0, normalDeg = 0, wrench = 0;  // wrench: max of force and torque error
  int cases = 0, cannot = 0;
  int wrong = 0;          // of `cases`: a depth is wrong (kWrongDepth) or a contact is missed
  double depthTimes = 0;  // mean of found depth / true depth, over the cases with a wrong depth
  bool frontier = false;  // no other is both faster and more accurate

  // All cases answered, none wrongly. Only such marks can be on the frontier.
  bool whole() const { return cases > 0 && cannot == 0 && wrong == 0; }
};
std::vector<FamilyMark> familyMarks(const std::vector<ChartRow>& rows);
// Sets `frontier` of each row from its family's mark.
void markFrontier(std::vector<ChartRow>& rows);

// Per family: the most accurate method and the fastest within error bounds, one line each.
std::vector<std::string> advice(const std::vector<ChartRow>& rows);

}  // namespace cloudcontact::program::lab
