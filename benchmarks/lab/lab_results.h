// The laboratory's output files: chart.json, failures.json, their pictures as .svg and .png, and
// report.html.
#pragma once

#include <string>
#include <vector>

#include "lab/chart.h"
#include "lab/stability.h"

namespace cloudcontact::program::lab {

struct LabResults {
  std::vector<LabMethod> methods;  // that took part
  std::vector<ChartRow> chart;
  std::vector<StabilityRow> stability;
  std::vector<std::string> faults;  // of CloudContact (self_check.h)
  bool quick = false;
  std::string command;  // the command line
  double seconds = 0;   // of the whole run
  std::string subject;  // a user's pair; empty: the reference cases
};

// Creates `folder` if needed, and returns whether it was. Throws BadInput where it cannot be
// created or written.
bool makeFolder(const std::string& folder);
// Returns the names of the files that say something of these results. Throws WorkFailed where
// python3 or matplotlib is missing; the JSON files are written even then.
std::string writeResults(const LabResults& results, const std::string& folder);

}  // namespace cloudcontact::program::lab
