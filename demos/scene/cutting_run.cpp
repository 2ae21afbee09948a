// Runs the ticks. Archard's volume is summed here from the loop's force, speed and touched voxels,
// independently of the cutter. The removed volume is that of the workpiece before minus after. The
// two agree only if the cutter follows its law.
#include "scene/cutting_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

namespace cloudcontact::program {

namespace {

// Removed volume for each joule of work on the touched voxels [m^3/J].
double softness(const BaseVectorField& workpiece, const Collision& collision,
                const Cutter& cutter) {
  double sum = 0;
  for (const CollisionVoxel& v : collision.voxels) {
    const double ability = static_cast<double>(v.ability);
    const double hardness = workpiece.tissues()[v.tissue].hardness;
    if (ability * cutter.hardness > hardness)
      sum += ability * static_cast<double>(v.share) / std::max(hardness, 1e-9 * cutter.hardness);
  }
  return collision.count > 0 ? sum / collision.count : 0;
}

// Archard's volume of one tick.
double workVolume(const BaseVectorField& workpiece, const Collision& before, const Cutter& cutter,
                  const HapticInput& in, const HapticOutput& out, double step) {
  if (before.empty() || !(out.depth > 0)) return 0;
  const Vec3 outward = before.normal();
  const double press = std::max(0.0, out.onHand.force.dot(outward));
  const double slide = (in.velocity - in.velocity.dot(outward) * outward).norm();
  return cutter.efficiency * press * (cutter.edgeSpeed + slide) * step *
         softness(workpiece, before, cutter);
}

}  // namespace

PlannedPath::PlannedPath(std::vector<PathPoint> points) : points_(std::move(points)) {
  if (points_.empty()) throw std::invalid_argument("PlannedPath: give at least one point");
  double time = 0;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const PathPoint& p = points_[k];
    if (!p.place.allFinite() || !(p.rest >= 0) || !std::isfinite(p.rest) ||
        (k > 0 && (!(p.speed > 0) || !std::isfinite(p.speed))))
      throw std::invalid_argument(
          "PlannedPath: places must be finite, speeds positive, rests zero or more");
    if (k > 0) time += (p.place - points_[k - 1].place).norm() / p.speed;
    time += p.rest;
    arrivals_.push_back(time);
  }
}

Vec3 PlannedPath::at(double time) const {
  const auto next = std::upper_bound(arrivals_.begin(), arrivals_.end(), time);
  if (next == arrivals_.end()) return points_.back().place;
  const auto k = static_cast<std::size_t>(next - arrivals_.begin());
  if (k == 0) return points_.front().place;
  const double way = (points_[k].place - points_[k - 1].place).norm();
  const double gone = std::max(time - arrivals_[k - 1], 0.0) * points_[k].speed;
  if (gone >= way) return points_[k].place;  // pausing
  return points_[k - 1].place + gone / way * (points_[k].place - points_[k - 1].place);
}

CuttingRun runCutting(BaseVectorField& workpiece, const CuttingTask& task) {
  if (!task.haptic.cutter) throw std::invalid_argument("runCutting: the task has no cutter");
  const double step = task.haptic.step;
  HapticLoop loop(workpiece, {}, task.haptic);
  SimulatedHand hand(task.hand, task.path.at(0));
  CuttingRun run;
  run.step = step;
  for (const Tissue& t : workpiece.tissues()) run.tissues.push_back(t.name);
  const auto count = static_cast<std::size_t>(std::ceil(task.path.seconds() / step)) + 1;
  run.ticks.reserve(count);
  run.shares.reserve(count * run.tissues.size());
  run.volumeBefore = workpiece.mass().volume;
  run.massBefore = workpiece.mass().mass;
  CuttingTick tick;
  bool cutBefore = false;
  for (std::size_t k = 0; k < count; ++k) {
    const HapticInput in{{task.orientation, hand.position()}, hand.velocity()};
    const auto start = std::chrono::steady_clock::now();
    const HapticOutput& out = loop.tick(in);
    tick.microseconds =
        std::chrono::duration<float, std::micro>(std::chrono::steady_clock::now() - start).count();
    const Collision& touched = loop.collision();
    tick.time = static_cast<double>(k) * step;
    tick.hand = in.hand.position;
    tick.tool = out.tool.position;
    tick.force = out.onHand.force;
    tick.center = touched.empty() ? tick.tool : touched.center;
    tick.depth = out.depth;
    tick.cut += out.cutVolume;
    tick.work += workVolume(workpiece, touched, *task.haptic.cutter, in, out, step);
    tick.energy = out.energy;
    tick.cutting = cutBefore || out.cutVoxels > 0;
    cutBefore = out.cutVoxels > 0;
    run.ticks.push_back(tick);
    for (std::size_t t = 0; t < run.tissues.size(); ++t)
      run.shares.push_back(
          out.depth > 0 ? static_cast<float>(touched.tissueCount[t] / touched.count) : 0.f);
    hand.advance(task.path.at(tick.time + step), out.onHand.force, step);
    run.leastEnergy = out.leastEnergy;
    if (task.progress && k % 64 == 0)
      task.progress(static_cast<double>(k) / static_cast<double>(count));
  }
  if (task.progress) task.progress(1);
  run.volumeAfter = workpiece.mass().volume;
  run.massAfter = workpiece.mass().mass;
  return run;
}

}  // namespace cloudcontact::program
