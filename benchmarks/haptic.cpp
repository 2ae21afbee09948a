// Times every tick of a 1 kHz haptic loop on one core in which a round bur opens a tooth of two
// million voxels. After each tick an empty wait of the same length is timed; what exceeds it is the
// machine's own delay. Also compares a cut with building the field again.
//   haptic [SECONDS]     (60)
#include <cloudcontact/workpiece/haptic_loop.h>
#include <cloudcontact/workpiece/simulated_hand.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "scene/tooth.h"

namespace {

using namespace cloudcontact;
using Clock = std::chrono::steady_clock;

constexpr double kVoxels = 2e6, kStep = 1e-3;

double since(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

// The tooth with at least two million voxels of matter.
Cloud largeTooth() {
  const Cloud coarse = program::toothCloud(2e-4);
  const double volume = coarse.massProperties().volume;
  return program::toothCloud(std::cbrt(volume / (1.02 * kVoxels)));
}

struct Ticks {
  std::vector<double> micros, idle;  // [us] of each tick; delay of the empty wait after it
  std::vector<Vec3> forces;
  std::vector<bool> cut;
};

double quantile(std::vector<double> v, double q) {
  std::sort(v.begin(), v.end());
  return v[static_cast<std::size_t>(q * static_cast<double>(v.size() - 1))];
}

// The tool's path: down through the crown, sweeping sideways.
Vec3 plan(double time, double seconds, const Vec3& top) {
  const double depth = 4e-3 * time / seconds;
  return top + Vec3(1e-3 * std::sin(2.1 * time), 0.8e-3 * std::sin(1.3 * time), 1e-3 - depth);
}

Ticks drill(BaseVectorField& tooth, const Vec3& top, double seconds, HapticOutput& last) {
  HapticSettings settings;
  settings.tool.area = {Sphere{0.5e-3}};  // a round bur of 1 mm
  settings.step = kStep;
  settings.cutter = Cutter{17e9, 0.3, 5};
  HapticLoop loop(tooth, {}, settings);
  SimulatedHand hand({}, plan(0, seconds, top));
  Ticks ticks;
  const int count = static_cast<int>(seconds / kStep);
  for (int k = 0; k < count; ++k) {
    const auto start = Clock::now();
    last = loop.tick({{Eigen::Quaterniond::Identity(), hand.position()}, hand.velocity()});
    const double time = since(start);
    const auto wait = Clock::now();
    while (since(wait) < time) {
    }
    ticks.idle.push_back(since(wait) - time);
    ticks.micros.push_back(time);
    ticks.forces.push_back(last.onHand.force);
    ticks.cut.push_back(last.cutVoxels > 0);
    hand.advance(plan(kStep * k, seconds, top), last.onHand.force, kStep);
  }
  return ticks;
}

// The largest relative change of the force between ticks, among forces of at least a tenth of the
// largest.
double worstStep(const Ticks& t, bool cutting) {
  double most = 0, worst = 0;
  for (const Vec3& f : t.forces) most = std::max(most, f.norm());
  for (std::size_t k = 1; k < t.forces.size(); ++k)
    if (t.cut[k - 1] == cutting && t.forces[k].norm() > 0.1 * most)
      worst = std::max(worst, (t.forces[k] - t.forces[k - 1]).norm() / t.forces[k].norm());
  return worst;
}

void timeCuts(const BaseVectorField& tooth, const Vec3& top, const TissueTable& tissues) {
  const auto built = Clock::now();
  BaseVectorField field(tooth.cloud(), tissues, sphereWindow(tooth.voxelSize()));
  const double build = since(built);
  field.reserve();
  const VoxelIndex at =
      ((top - field.origin()) / field.voxelSize()).cast<int>() + VoxelIndex(-5, -5, -60);
  std::vector<double> times;
  for (int n = 0; n < 25; ++n) {
    std::vector<VoxelCut> cuts;
    for (int k = 0; k < 1000; ++k)
      cuts.push_back(
          {at + VoxelIndex(12 * (n % 5) - 24 + k % 10, 12 * (n / 5) - 24 + k / 10 % 10, k / 100),
           0});
    const auto start = Clock::now();
    if (field.cut(cuts) > 900) times.push_back(since(start));
  }
  if (times.empty()) return;
  std::printf(
      "cut of 1000 voxels     median %.0f us, worst %.0f us of %zu; building the field takes %.0f "
      "times as long\n",
      quantile(times, 0.5), quantile(times, 1), times.size(), build / quantile(times, 0.5));
}

}  // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 60;
  const Cloud cloud = largeTooth();
  const TissueTable tissues = tissuesOf(dentalTissues(), cloud.materials());
  const VoxelCounts counts = cloud.counts();
  BaseVectorField tooth(cloud, tissues, sphereWindow(cloud.voxelSize()));
  // The top of the crown above its center.
  Vec3 top(0, 0, cloud.origin().z() + cloud.voxelSize() * cloud.size().z());
  while (top.z() > cloud.origin().z() &&
         tooth.coverage(((top - tooth.origin()) / tooth.voxelSize()).cast<int>()) == 0)
    top.z() -= tooth.voxelSize();
  std::printf("tooth                  %zu voxels of %.1f um, %.0f MB\n",
              counts.inside + counts.interface, 1e6 * tooth.voxelSize(),
              static_cast<double>(tooth.bytes()) / 1e6);
  timeCuts(tooth, top, tissues);
  HapticOutput last;
  const double before = tooth.mass().volume;
  const Ticks t = drill(tooth, top + Vec3(0, 0, 0.5e-3), seconds, last);
  std::size_t cutting = 0;
  for (const bool c : t.cut) cutting += c;
  double most = 0;
  for (const Vec3& f : t.forces) most = std::max(most, f.norm());
  std::printf(
      "ticks                  %zu, of which %zu cut; %.2f mm^3 removed, force up to %.2f N\n",
      t.micros.size(), cutting, 1e9 * (before - tooth.mass().volume), most);
  std::printf("time of a tick         median %.1f us, p99 %.1f us, worst %.1f us\n",
              quantile(t.micros, 0.5), quantile(t.micros, 0.99), quantile(t.micros, 1));
  const auto slowest = std::max_element(t.micros.begin(), t.micros.end()) - t.micros.begin();
  std::printf("slowest tick           number %td, its neighbors %.1f and %.1f us\n", slowest,
              t.micros[static_cast<std::size_t>(std::max<std::ptrdiff_t>(slowest - 1, 0))],
              t.micros[std::min(t.micros.size() - 1, static_cast<std::size_t>(slowest + 1))]);
  std::printf("delay of the machine   p99 %.1f us, worst %.1f us\n", quantile(t.idle, 0.99),
              quantile(t.idle, 1));
  // A slow tick repeats in a second run of the same motion; a pause of the machine does not.
  BaseVectorField untouched(cloud, tissues, sphereWindow(cloud.voxelSize()));
  const Ticks again = drill(untouched, top + Vec3(0, 0, 0.5e-3), seconds, last);
  std::vector<double> both;
  for (std::size_t k = 0; k < t.micros.size(); ++k)
    both.push_back(std::min(t.micros[k], again.micros[k]));
  std::printf("second run             worst %.1f us; slow in both runs %.1f us%s\n",
              quantile(again.micros, 1), quantile(both, 1),
              again.forces == t.forces ? "" : " (the forces differ!)");
  std::printf("jump of the force      %.2f %% without a cut, %.2f %% with a cut\n",
              100 * worstStep(t, false), 100 * worstStep(t, true));
  std::printf("energy from the hand   %.3g J, minimum %.3g J\n", last.energy, last.leastEnergy);
}
