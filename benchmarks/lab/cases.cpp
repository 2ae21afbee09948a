// All cases, in the order of the chart.
#include "lab/cases.h"

namespace cloudcontact::program::lab {

std::vector<LabCase> allCases() {
  std::vector<LabCase> cases = convexCases();
  for (const auto& more : {concaveCases(), grooveCases(), deepCases(), randomCases()})
    cases.insert(cases.end(), more.begin(), more.end());
  return cases;
}

}  // namespace cloudcontact::program::lab
