// Error against time: every method and setting on every case.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "lab/cases.h"

namespace cloudcontact::program::lab {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

struct Spread {
  double mean = kUnknown, p95 = kUnknown, max = kUnknown;
};

// How far the contacts of one method on one case are from the truth, over grids and depths; NaN
// where the truth is not known, or the method has no answer.
struct ChartRow {
  std::string family, name, method, setting;
  bool convex = false, smooth = false;
  double detail = 0;               // by the case's size
  double microseconds = kUnknown;  // median of the narrow phase
  Spread normalDeg;                // of the whole force's direction
  double depth = kUnknown;         // [m] mean size of the deepest point's error
  double centre = kUnknown;        // [m] from the true centre to the force's axis
  double force = kUnknown;         // of its size, relative, mean
  double torque = kUnknown;        // about the true centre, by force and size, mean
  int runs = 0, missed = 0;        // missed: touching, and nothing reported
  bool frontier = false;           // in its family no other is faster and more accurate
  std::string why;                 // where the method cannot
};

struct ChartSettings {
  bool quick = false;
  std::string only;  // a part of a case's name or family; empty: all
  std::function<void(double)> progress;
};

std::vector<ChartRow> runChart(const ChartSettings& settings);
std::vector<ChartRow> runChart(const std::vector<LabCase>& cases,
                               const std::vector<LabMethod>& methods,
                               const ChartSettings& settings);
// The same for a pair of the user's own; the finest cloud stands for the truth.
std::vector<ChartRow> runChart(const LabCase& pair, const ChartSettings& settings);

// A method and setting over a family: means over its cases. Cases that it cannot do are not in it.
struct FamilyMark {
  std::string family, method, setting;
  double microseconds = 0, normalDeg = 0, wrench = 0;  // wrench: the larger of force and torque
  int cases = 0, cannot = 0;
  bool frontier = false;
};
std::vector<FamilyMark> familyMarks(const std::vector<ChartRow>& rows);
// Sets the rows' `frontier` from their families'.
void markFrontier(std::vector<ChartRow>& rows);

// Errors of one answer against the truth; part of the laboratory's own check.
struct AnswerError {
  double normalDeg = 180, depth = kUnknown, centre = kUnknown, force = kUnknown, torque = kUnknown;
};
AnswerError errorOf(const std::vector<LabPoint>& points, const Truth& truth, double size);

}  // namespace cloudcontact::program::lab
