// A tool in a simulated hand that cuts a workpiece along a planned path, tick by tick, and what
// each tick said: what the demos drill and scalpel and the command drill run.
#pragma once

#include <cloudcontact/workpiece/haptic_loop.h>
#include <cloudcontact/workpiece/simulated_hand.h>

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace cloudcontact::program {

// The way from one place to the next, at an even speed.
struct PathPoint {
  Vec3 place = Vec3::Zero();  // [m] world
  double speed = 1e-3;        // [m/s] on the way here; the first point's says nothing
  double rest = 0;            // [s] there, before the way goes on
};

// Throws std::invalid_argument where there is no point, one is not finite, or a speed is not
// positive.
class PlannedPath {
 public:
  explicit PlannedPath(std::vector<PathPoint> points);
  double seconds() const { return arrivals_.back(); }  // with all rests
  Vec3 at(double time) const;                          // before the start and after the end: there
  const std::vector<PathPoint>& points() const { return points_; }

 private:
  std::vector<PathPoint> points_;
  std::vector<double> arrivals_;  // [s] when each point is left
};

struct CuttingTask {
  HapticSettings haptic;  // with a cutter
  HandSettings hand;
  PlannedPath path;                                                 // of the tool's origin
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  // of the tool, kept
  std::function<void(double)> progress;  // called with 0..1, may be empty
};

struct CuttingTick {
  double time = 0;                                // [s]
  Vec3 hand = Vec3::Zero(), tool = Vec3::Zero();  // [m]
  Vec3 force = Vec3::Zero();                      // on the hand [N]
  Vec3 center = Vec3::Zero();                     // where the tool is touched [m]
  double depth = 0;                               // the tool's embedding, d [m]
  double cut = 0, work = 0;  // [m^3] so far: gone, and what Archard's law gives for the work
  double energy = 0;         // [J] that the hand has given so far
  float microseconds = 0;    // that the tick took
  bool cutting = false;      // matter went in this tick or the one before
};

struct CuttingRun {
  double step = 0;                   // [s] of a tick
  std::vector<std::string> tissues;  // in the order of the workpiece's
  std::vector<CuttingTick> ticks;
  std::vector<float> shares;  // of the touched voxels, by tissue, tick by tick; none touched: zeros
  double volumeBefore = 0, volumeAfter = 0;  // [m^3] of the workpiece
  double massBefore = 0, massAfter = 0;      // [kg]
  double leastEnergy = 0;                    // [J]

  std::span<const float> sharesAt(std::size_t tick) const {
    return {shares.data() + tick * tissues.size(), tissues.size()};
  }
};

// Runs the whole path, one tick after the other, and cuts the workpiece, which lies at the world's
// origin. The same on every run but for the times. Throws std::invalid_argument as HapticLoop and
// SimulatedHand do, and where the task has no cutter.
CuttingRun runCutting(BaseVectorField& workpiece, const CuttingTask& task);

}  // namespace cloudcontact::program
