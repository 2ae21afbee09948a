// The pace of a run (pace.h).
#include "view/pace.h"

#include <algorithm>

namespace cloudcontact::program {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr Seconds kLate{0.1};     // from here on time is lost, not made up for
constexpr Seconds kLooks{0.5};    // between looks at what is reached
constexpr Seconds kLongest{1e9};  // until a step is due: 30 years, which the clock can hold

}  // namespace

void Pace::set(double speed, double time, Clock::time_point now) {
  speed_ = speed;
  from_ = lookTime_ = time;
  start_ = look_ = now;
}

Pace::Clock::time_point Pace::due(double time, Clock::time_point now) {
  if (!(speed_ > 0)) return now;
  const Seconds wait = std::min(Seconds((time - from_) / speed_), kLongest);
  const auto due = start_ + std::chrono::duration_cast<Clock::duration>(wait);
  if (now - due <= kLate) return due;
  from_ = time;
  start_ = now;
  return now;
}

double Pace::reached(double time, Clock::time_point now) {
  const Seconds passed = now - look_;
  if (passed >= kLooks) {
    reached_ = (time - lookTime_) / passed.count();
    lookTime_ = time;
    look_ = now;
  }
  return reached_;
}

}  // namespace cloudcontact::program
