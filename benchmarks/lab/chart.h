// Error against time: runs every method at every setting on every case.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "lab/cases.h"
#include "lab/chart_row.h"

namespace cloudcontact::program::lab {

struct ChartSettings {
  bool quick = false;
  int threads = 2;     // for queries; times are measured on one thread with nothing beside it
  std::string only;    // a part of a case's name or family; empty: all
  std::string method;  // the only one, as --method names it; empty: all
  std::function<void(double)> progress;
};

// The methods of the chart, CloudContact first.
std::vector<LabMethod> chartMethods(const ChartSettings& settings);

std::vector<ChartRow> runChart(const ChartSettings& settings);
std::vector<ChartRow> runChart(const std::vector<LabCase>& cases,
                               const std::vector<LabMethod>& methods,
                               const ChartSettings& settings);
// The chart of a user's pair. Its true contact is not known, so the finest cloud is the reference.
// Throws std::runtime_error where the bodies do not touch.
std::vector<ChartRow> runChart(const LabCase& pair, const ChartSettings& settings);

}  // namespace cloudcontact::program::lab
