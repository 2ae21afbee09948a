// When the next step of a run is due, so that it keeps to real time or a multiple of it.
#pragma once

#include <chrono>

namespace cloudcontact::program {

class Pace {
 public:
  using Clock = std::chrono::steady_clock;

  // `speed`: times real time; 0: as fast as it can.
  void set(double speed, double time, Clock::time_point now);
  double speed() const { return speed_; }
  // When the step that starts at `time` [s] is due. A run that is late by more than a moment does
  // not catch up: it goes on from now.
  Clock::time_point due(double time, Clock::time_point now);
  // The speed that is reached, times real time, over the last moments; 0 until it is known.
  double reached(double time, Clock::time_point now);

 private:
  double speed_ = 1;
  double from_ = 0;          // simulated [s]
  Clock::time_point start_;  // when `from_` was due
  double lookTime_ = 0;      // of the latest look at what is reached
  Clock::time_point look_;
  double reached_ = 0;
};

}  // namespace cloudcontact::program
