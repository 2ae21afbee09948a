// The progress bar: one line that is overwritten, whichever thread reports.
#include "progress.h"

#include <unistd.h>

#include <cstdio>
#include <memory>
#include <mutex>

namespace cloudcontact::program {

std::function<void(double)> progressBar(const std::string& label) {
  if (isatty(STDERR_FILENO) == 0) return {};
  struct State {
    std::mutex mutex;
    int percent = -1;
  };
  auto state = std::make_shared<State>();
  return [state, label](double done) {
    const std::lock_guard lock(state->mutex);
    const int percent = static_cast<int>(100 * done);
    if (percent <= state->percent) return;  // threads may report out of order
    state->percent = percent;
    if (percent >= 100)
      std::fprintf(stderr, "\r\033[K");
    else
      std::fprintf(stderr, "\r%s %3d %%", label.c_str(), percent);
    std::fflush(stderr);
  };
}

}  // namespace cloudcontact::program
