// What the laboratory leaves: chart.json, chart.svg and .png, failures.json, failures.svg and .png,
// report.html (CLI.md).
#pragma once

#include <string>
#include <vector>

#include "lab/chart.h"
#include "lab/stability.h"

namespace cloudcontact::program::lab {

struct LabResults {
  std::vector<LabMethod> methods;  // that were asked
  std::vector<ChartRow> chart;
  std::vector<StabilityRow> stability;
  std::vector<std::string> faults;  // of our own method (self_check.h)
  bool quick = false;
  std::string command;  // as typed
  double seconds = 0;   // that it took
  std::string subject;  // a pair of the user's own; empty: the reference cases
};

// Makes `folder` where it is not there, and throws BadInput naming it where it cannot be written.
void checkFolder(const std::string& folder);
// Throws WorkFailed where python3 or its matplotlib is not there: the JSON files are then written.
void writeResults(const LabResults& results, const std::string& folder);

// Which method to take for which need, from the figures alone: a line each.
std::vector<std::string> advice(const std::vector<ChartRow>& rows);

}  // namespace cloudcontact::program::lab
