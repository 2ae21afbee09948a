// A progress bar on stderr, drawn only on a terminal.
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace cloudcontact::program {

// A callback for DigitizeSettings::progress and similar. It draws `label`, a bar, a percentage and,
// after half a second, the time left; at 1 it clears the line. Empty if stderr is not a terminal.
std::function<void(double)> progressBar(const std::string& label);

// What makes a callback like that of a label.
using ProgressMaker = std::function<std::function<void(double)>(const std::string& label)>;

// One bar for two pieces of work that run at the same time: the mean of both. Its end clears the
// line, also where the work throws.
class PairProgress {
 public:
  PairProgress(const ProgressMaker& maker, const std::string& label);
  ~PairProgress();
  PairProgress(const PairProgress&) = delete;
  PairProgress& operator=(const PairProgress&) = delete;

  // A callback for one of the two, `which` 0 or 1.
  std::function<void(double)> of(int which) const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

// "12 s left", "3 min left", "2 h 5 min left".
std::string timeLeftText(double seconds);

}  // namespace cloudcontact::program
