// One line of the chart: errors and time of one method, at one setting, on one case.
#pragma once

#include <string>

#include "lab/answer.h"

namespace cloudcontact::program::lab {

struct Spread {
  double mean = kUnknown, p95 = kUnknown, max = kUnknown;
};

// Errors over all grids and depths of the case; NaN where the truth is not known or the method has
// no answer.
struct ChartRow {
  std::string family, name, method, setting;
  bool convex = false, smooth = false;
  double detail = 0;                  // voxel or facet tolerance / size of the case
  double microseconds = kUnknown;     // median time of the narrow phase
  Spread normalDeg;                   // of the total force's direction
  double depth = kUnknown;            // [m] mean absolute error of the deepest point
  double depthTimes = kUnknown;       // mean of found depth / true depth
  double center = kUnknown;           // [m] from the true center to the force's axis
  double force = kUnknown;            // of the magnitude, relative, mean
  double torque = kUnknown;           // about the true center, relative to force * size, mean
  SwapError swapped;                  // on one grid, at the middle depth
  double loopWork = kUnknown;         // on one grid, at the middle depth
  double volume = kUnknown;           // of both bodies, relative; for clouds only
  std::size_t triangles[2] = {0, 0};  // of A and B, for methods that take facets
  std::size_t vertices[2] = {0, 0};
  int runs = 0, missed = 0;  // missed: the bodies touch, the method reports nothing
  int wrongDepth = 0;        // answers with a wrong depth (kWrongDepth)
  bool frontier = false;     // no method is both faster and more accurate on the family
  double seconds = 0;        // time of preparation, queries and timing
  std::string why;           // why the method cannot do the case
};

}  // namespace cloudcontact::program::lab
