// A progress bar on stderr, drawn only where stderr is a terminal.
#pragma once

#include <functional>
#include <string>

namespace cloudcontact::program {

// A callback for DigitizeSettings::progress and its like, which draws `label` and a percentage and
// wipes the line at 1. Empty (no callback at all) where stderr is not a terminal.
std::function<void(double)> progressBar(const std::string& label);

}  // namespace cloudcontact::program
