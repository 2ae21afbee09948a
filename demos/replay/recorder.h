// Records running worlds for a replay.
#pragma once

#include <memory>
#include <string>

#include "replay/replay.h"
#include "scene/world.h"

namespace cloudcontact::program {

class Recorder {
 public:
  // If a take has more contact points than `mostPoints` (84 MB by default), every other frame is
  // dropped.
  explicit Recorder(std::size_t mostPoints = 3'000'000);
  ~Recorder();

  // Starts a take: a world that will run for `seconds`, in steps of `step` [s]. It must outlive
  // the take's last record().
  void begin(const World& world, const std::string& label, double seconds, double step);
  // Call after each step, and once before the first (time 0).
  void record(double time, const World& world);
  // Call after the last record() of a run that may have ended before its `seconds`: otherwise cuts,
  // contacts and figures since the last frame are not in the replay.
  void close(const World& world);
  // Ends the recording and returns the takes, placed in a row. The caller fills title, story and
  // checks.
  Replay finish();

 private:
  struct Take;
  void endTake();
  void addFrame(double time, const World& world);

  std::size_t mostPoints_;
  Replay replay_;
  std::unique_ptr<Take> take_;  // the current one
};

}  // namespace cloudcontact::program
