// Watches worlds run and keeps what a replay shows.
#pragma once

#include <memory>
#include <string>

#include "replay/replay.h"
#include "scene/world.h"

namespace cloudcontact::program {

class Recorder {
 public:
  // Where a take's contacts become more points than that (84 MB by default), every other frame is
  // left out.
  explicit Recorder(std::size_t mostPoints = 3'000'000);
  ~Recorder();

  // Starts a take: a world that will run for `seconds`, in steps of `step` [s]. It must outlive
  // the take's last record().
  void begin(const World& world, const std::string& label, double seconds, double step);
  // After each step, and once before the first (time 0).
  void record(double time, const World& world);
  // Ends the recording: the takes in a row, thinned. title, story, checks are the caller's to fill.
  Replay finish();

 private:
  struct Take;
  void endTake();
  void addFrame(double time, const World& world);

  std::size_t mostPoints_;
  Replay replay_;
  std::unique_ptr<Take> take_;  // the one that runs
};

}  // namespace cloudcontact::program
