// A progress bar on stderr, drawn only where stderr is a terminal.
#pragma once

#include <functional>
#include <string>

namespace cloudcontact::program {

// A callback for DigitizeSettings::progress and its like, which draws `label`, a bar, a percentage
// and, from half a second on, the time left; at 1 it wipes the line. Empty (no callback at all)
// where stderr is not a terminal.
std::function<void(double)> progressBar(const std::string& label);

// "12 s left", "3 min left", "2 h 5 min left".
std::string timeLeftText(double seconds);

}  // namespace cloudcontact::program
