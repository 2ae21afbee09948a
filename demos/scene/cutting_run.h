// Runs a tool in a simulated hand along a planned path through a workpiece and records each tick of
// the haptic loop. The demos drill and scalpel and the command drill use it.
#pragma once

#include <cloudcontact/workpiece/haptic_loop.h>
#include <cloudcontact/workpiece/simulated_hand.h>

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace cloudcontact::program {

// A waypoint, reached at constant speed.
struct PathPoint {
  Vec3 place = Vec3::Zero();  // [m] world
  double speed = 1e-3;        // [m/s] on the way here; ignored for the first point
  double rest = 0;            // [s] pause there
};

// Throws std::invalid_argument if there is no point, one is not finite, or a speed is not positive.
class PlannedPath {
 public:
  explicit PlannedPath(std::vector<PathPoint> points);
  double seconds() const { return arrivals_.back(); }  // with all pauses
  Vec3 at(double time) const;                          // clamped to the start and the end
  const std::vector<PathPoint>& points() const { return points_; }

 private:
  std::vector<PathPoint> points_;
  std::vector<double> arrivals_;  // [s] when the tool leaves each point
};

struct CuttingTask {
  HapticSettings haptic;  // must have a cutter
  HandSettings hand;
  PlannedPath path;                                                 // of the tool's origin
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  // of the tool, constant
  std::function<void(double)> progress;  // called with 0..1, may be empty
};

struct CuttingTick {
  double time = 0;                                // [s]
  Vec3 hand = Vec3::Zero(), tool = Vec3::Zero();  // [m]
  Vec3 force = Vec3::Zero();                      // on the hand [N]
  Vec3 center = Vec3::Zero();                     // center of the contact [m]
  double depth = 0;                               // embedding depth d [m]
  double cut = 0, work = 0;                       // [m^3] so far: removed, and by Archard's law
  double energy = 0;                              // [J] from the hand so far
  float microseconds = 0;                         // duration of the tick
  bool cutting = false;                           // this tick or the one before removed material
};

struct CuttingRun {
  double step = 0;                   // [s] of a tick
  std::vector<std::string> tissues;  // in the order of the workpiece's
  std::vector<CuttingTick> ticks;
  std::vector<float> shares;  // of each tissue among the touched voxels, for each tick
  double volumeBefore = 0, volumeAfter = 0;  // [m^3] of the workpiece
  double massBefore = 0, massAfter = 0;      // [kg]
  double leastEnergy = 0;                    // [J]

  std::span<const float> sharesAt(std::size_t tick) const {
    return {shares.data() + tick * tissues.size(), tissues.size()};
  }
};

// Runs the whole path and cuts the workpiece, which lies at the world's origin. Deterministic but
// for the times. Throws std::invalid_argument as HapticLoop and SimulatedHand do, and if the task
// has no cutter.
CuttingRun runCutting(BaseVectorField& workpiece, const CuttingTask& task);

}  // namespace cloudcontact::program
