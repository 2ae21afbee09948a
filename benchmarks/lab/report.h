// The laboratory's answer as one page that needs no network.
#pragma once

#include <string>

#include "io/json.h"

namespace cloudcontact::program::lab {

struct ReportPictures {
  std::string chart, force, failures;  // SVG; failures may be empty
};

// From what chart.json and failures.json hold.
std::string reportHtml(const Json& chart, const Json& failures, const ReportPictures& pictures);

}  // namespace cloudcontact::program::lab
