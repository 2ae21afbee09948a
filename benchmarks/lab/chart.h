// Error against time: every method and setting on every case.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "lab/answer.h"
#include "lab/cases.h"

namespace cloudcontact::program::lab {

struct Spread {
  double mean = kUnknown, p95 = kUnknown, max = kUnknown;
};

// How far the contacts of one method on one case are from the truth, over grids and depths; NaN
// where the truth is not known, or the method has no answer.
struct ChartRow {
  std::string family, name, method, setting;
  bool convex = false, smooth = false;
  double detail = 0;                  // by the case's size
  double microseconds = kUnknown;     // median of the narrow phase
  Spread normalDeg;                   // of the whole force's direction
  double depth = kUnknown;            // [m] mean size of the deepest point's error
  double depthTimes = kUnknown;       // that point's depth by the true one, mean
  double centre = kUnknown;           // [m] from the true centre to the force's axis
  double force = kUnknown;            // of its size, relative, mean
  double torque = kUnknown;           // about the true centre, by force and size, mean
  SwapError swapped;                  // on one grid, at the middle depth
  double loopWork = kUnknown;         // the same: net work around a closed loop, as a share
  double volume = kUnknown;           // of both bodies, relative; of clouds alone
  std::size_t triangles[2] = {0, 0};  // of A and B, for methods that take facets
  std::size_t vertices[2] = {0, 0};
  int runs = 0, missed = 0;  // missed: touching, and nothing reported
  int wrongDepth = 0;        // answers whose depth is wrong (answer.h)
  bool frontier = false;     // in its family no other is faster and more accurate
  double seconds = 0;        // that making ready, asking and timing took
  std::string why;           // where the method cannot
};

// "CloudContact" for "cloud": what readers of the chart see.
std::string shownName(const std::string& method);

struct ChartSettings {
  bool quick = false;
  int threads = 2;   // for what is asked; times are taken on one, alone
  std::string only;  // a part of a case's name or family; empty: all
  std::function<void(double)> progress;
};

// All that take part, ours first.
std::vector<LabMethod> chartMethods(const ChartSettings& settings);

std::vector<ChartRow> runChart(const ChartSettings& settings);
std::vector<ChartRow> runChart(const std::vector<LabCase>& cases,
                               const std::vector<LabMethod>& methods,
                               const ChartSettings& settings);
// The same for a pair of the user's own; the finest cloud stands for the truth.
std::vector<ChartRow> runChart(const LabCase& pair, const ChartSettings& settings);

}  // namespace cloudcontact::program::lab
