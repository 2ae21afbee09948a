// A progress bar on stderr, drawn only on a terminal.
#pragma once

#include <functional>
#include <string>

namespace cloudcontact::program {

// A callback for DigitizeSettings::progress and similar. It draws `label`, a bar, a percentage and,
// after half a second, the time left; at 1 it clears the line. Empty if stderr is not a terminal.
std::function<void(double)> progressBar(const std::string& label);

// What makes a callback like that of a label.
using ProgressMaker = std::function<std::function<void(double)>(const std::string& label)>;

// "12 s left", "3 min left", "2 h 5 min left".
std::string timeLeftText(double seconds);

}  // namespace cloudcontact::program
