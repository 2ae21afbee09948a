// The results as one HTML page that needs no network.
#pragma once

#include <string>

#include "io/json.h"

namespace cloudcontact::program::lab {

struct ReportPictures {
  std::string chart, force, failures, running;  // SVG; the last two may be empty
};

// From the contents of chart.json and failures.json.
std::string reportHtml(const Json& chart, const Json& failures, const ReportPictures& pictures);

}  // namespace cloudcontact::program::lab
