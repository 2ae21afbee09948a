// Sums over the ticks of a run.
#include "scene/cutting_figures.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact::program {

namespace {

constexpr float kTouched = 0.05f;  // least share of the touched voxels; corners touch less
constexpr float kAlone = 0.9f;
constexpr double kFaint = 0.1;  // share of the largest force, below which steps do not count

void addTissues(const CuttingRun& run, CuttingFigures& figures) {
  for (const std::string& name : run.tissues) figures.tissues.push_back({name, {}, 0, 0});
  for (std::size_t k = 0; k < run.ticks.size(); ++k)
    for (std::size_t t = 0; t < run.tissues.size(); ++t) {
      TissueFigures& f = figures.tissues[t];
      const float share = run.sharesAt(k)[t];
      if (share >= kTouched && !f.firstTouch) f.firstTouch = run.ticks[k].time;
      if (share < kAlone) continue;
      f.seconds += run.step;
      f.meanForce += run.step * run.ticks[k].force.norm();
    }
  for (TissueFigures& f : figures.tissues)
    if (f.seconds > 0) f.meanForce /= f.seconds;
}

void addSteps(const CuttingRun& run, CuttingFigures& figures) {
  for (const CuttingTick& t : run.ticks)
    figures.mostForce = std::max(figures.mostForce, t.force.norm());
  for (std::size_t k = 1; k < run.ticks.size(); ++k) {
    const Vec3 &now = run.ticks[k].force, &before = run.ticks[k - 1].force;
    const double size = std::max(now.norm(), before.norm());
    if (size < kFaint * figures.mostForce) continue;
    double& largest = run.ticks[k].cutting ? figures.largestCuttingStep : figures.largestStep;
    largest = std::max(largest, (now - before).norm() / size);
  }
}

void addTimes(const CuttingRun& run, CuttingFigures& figures) {
  std::vector<float> times;
  for (const CuttingTick& t : run.ticks)
    if (t.depth > 0) times.push_back(t.microseconds);
  if (times.empty()) return;
  std::sort(times.begin(), times.end());
  figures.medianMicroseconds = static_cast<double>(times[times.size() / 2]);
  figures.p99Microseconds = static_cast<double>(times[times.size() * 99 / 100]);
}

}  // namespace

CuttingFigures figuresOf(const CuttingRun& run) {
  CuttingFigures figures;
  addTissues(run, figures);
  addSteps(run, figures);
  addTimes(run, figures);
  figures.cutVolume = run.volumeBefore - run.volumeAfter;
  if (!run.ticks.empty()) figures.workVolume = run.ticks.back().work;
  return figures;
}

double meanForce(const CuttingRun& run, double from, double to) {
  double sum = 0;
  int count = 0;
  for (const CuttingTick& t : run.ticks) {
    if (t.time < from || t.time > to || !(t.depth > 0)) continue;
    sum += t.force.norm();
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

std::vector<double> materialVolumes(const Cloud& cloud) {
  std::vector<std::uint64_t> sums(std::max<std::size_t>(cloud.materials().size(), 1), 0);
  const Eigen::Vector3i size = cloud.size();
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x)
        if (const int c = cloud.coverage(x, y, z))
          sums[cloud.materials().empty() ? 0 : cloud.material(x, y, z)] += std::uint64_t(c);
  std::vector<double> volumes;
  const double h = cloud.voxelSize();
  for (const std::uint64_t sum : sums) volumes.push_back(double(sum) / 255 * h * h * h);
  return volumes;
}

}  // namespace cloudcontact::program
