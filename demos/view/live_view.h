// A world in the browser while it runs: the replay's page, fed over a local socket. The page pauses
// the run, steps it, pulls bodies and cuts them. A run in which nobody does is equal, to the bit,
// to one without a view.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "scene/world.h"

namespace cloudcontact::program {

class PageServer;

struct LiveViewSettings {
  double step = 1e-3;  // the longest that the world is stepped by [s]
  double speed = 1;    // times real time; 0: as fast as it can
  std::string title;   // of the page
  std::string setup;   // method, voxel, step (setupText())
  double voxel = 0;    // [m] 0: the method has none
};

class LiveView {
 public:
  // Serves the page of the world, which has run for `time` [s]. The world must outlive it. The
  // server, which serves nothing yet, may be older than the world, so that a port in use is found
  // before a world is built.
  LiveView(World& world, double time, const LiveViewSettings& settings,
           std::unique_ptr<PageServer> server);
  // Ends, and waits up to a second for the pages to close.
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  // For a browser on this machine. Whoever knows it can steer the run.
  const std::string& url() const;

  // Call it after each step, between steps. Does what the pages ask for, shows them the world, and
  // returns when the next step is due: at once, or after a pause. `goesOn` is asked about every 50
  // ms; once it is false, so is the return value, at once.
  bool follow(double time, const std::function<bool()>& goesOn);

  // Tells the pages that the run is over, and why if it failed (a line is enough). The last thing
  // that uses the world.
  void end(const std::string& why = "");

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact::program
