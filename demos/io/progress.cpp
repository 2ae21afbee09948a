// The progress bar: one line, overwritten at each report from any thread.
#include "io/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <mutex>

namespace cloudcontact::program {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kBar = 24;              // cells
constexpr double kFirstGuess = 0.5;   // delay before the time left is shown [s]
constexpr double kRedraw = 0.1;       // least time between drawings [s]
constexpr std::size_t kLineEnd = 52;  // most columns for bar, percentage and time

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::size_t terminalWidth() {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return 80;
  return size.ws_col;
}

struct Bar {
  std::string label;
  std::mutex mutex;
  Clock::time_point start = Clock::now(), drawn{};
  double most = 0;
  bool ended = false;

  void draw(double done) {
    const std::size_t width = terminalWidth();
    const std::size_t room = width > kLineEnd ? width - kLineEnd : 0;
    const auto full = static_cast<std::size_t>(kBar * done);
    const std::string line = std::string(full, '#') + std::string(kBar - full, '-');
    const double passed = secondsSince(start);
    const std::string left =
        passed >= kFirstGuess && done > 0 ? "  " + timeLeftText(passed * (1 - done) / done) : "";
    std::fprintf(stderr, "\r\033[K%s [%s] %2d %%%s", label.substr(0, room).c_str(), line.c_str(),
                 static_cast<int>(100 * done), left.c_str());
    std::fflush(stderr);
    drawn = Clock::now();
  }
};

}  // namespace

std::string timeLeftText(double seconds) {
  const auto whole = static_cast<long>(std::ceil(seconds));
  if (whole < 60) return std::to_string(whole) + " s left";
  if (whole < 3600) return std::to_string((whole + 59) / 60) + " min left";
  return std::to_string(whole / 3600) + " h " + std::to_string(whole % 3600 / 60) + " min left";
}

std::function<void(double)> progressBar(const std::string& label) {
  if (isatty(STDERR_FILENO) == 0) return {};
  auto bar = std::make_shared<Bar>();
  bar->label = label;
  return [bar](double done) {
    const std::lock_guard lock(bar->mutex);
    if (bar->ended || done <= bar->most) return;  // threads may report out of order
    bar->most = std::min(done, 1.0);
    if (done >= 1) {
      bar->ended = true;
      std::fprintf(stderr, "\r\033[K");
      std::fflush(stderr);
    } else if (secondsSince(bar->drawn) >= kRedraw) {
      bar->draw(done);
    }
  };
}

struct PairProgress::State {
  std::function<void(double)> bar;
  std::atomic<double> done[2] = {0, 0};
};

PairProgress::PairProgress(const ProgressMaker& maker, const std::string& label)
    : state_(std::make_shared<State>()) {
  state_->bar = maker(label);
}

std::function<void(double)> PairProgress::of(int which) const {
  if (!state_->bar) return {};
  return [state = state_, which](double done) {
    state->done[which] = done;
    // At 1 the bar ends, which is for the destructor to say.
    const double mean = (state->done[0] + state->done[1]) / 2;
    if (mean < 1) state->bar(mean);
  };
}

PairProgress::~PairProgress() {
  if (state_->bar) state_->bar(1);
}

}  // namespace cloudcontact::program
