// The chart of a user's own pair: of its contact nothing is known, so that the finest cloud stands
// for the truth.
#include <algorithm>

#include "lab/chart.h"

namespace cloudcontact::program::lab {
namespace {

// What a method finds, as the truth for the others.
Truth asTruth(const std::vector<LabPoint>& points) {
  Vec3 torque = Vec3::Zero();
  double deepest = 0;
  for (const LabPoint& p : points) {
    torque += p.position.cross(p.share * p.depth * p.normal);
    deepest = std::max(deepest, p.depth);
  }
  const Vec3 force = forceOf(points);
  if (!(force.norm() > 0))
    throw std::runtime_error("chart: the bodies do not touch at this --pose; press them together");
  Truth truth;
  truth.direction = force.normalized();
  truth.depth = force.norm();
  truth.deepest = deepest;
  truth.centre = force.cross(torque) / force.squaredNorm();
  return truth;
}

}  // namespace

std::vector<ChartRow> runChart(const LabCase& pair, const ChartSettings& settings) {
  std::vector<LabMethod> methods = chartMethods({});
  const auto finest =
      std::min_element(methods.begin(), methods.end(), [](const LabMethod& a, const LabMethod& b) {
        return std::pair(a.method != "cloud", a.detail) < std::pair(b.method != "cloud", b.detail);
      });
  const Instance instance = pair.make(1000);
  const LabPair reference = finest->prepare(instance.a, instance.b, finest->detail * pair.size);
  const Truth truth = asTruth(reference.find(instance.placements.front().b));
  methods.erase(finest);
  LabCase known = pair;
  known.make = [=](std::uint64_t seed) {
    Instance one = pair.make(seed);
    for (Placement& p : one.placements) p.truth = truth;
    return one;
  };
  return runChart({known}, methods, settings);
}

}  // namespace cloudcontact::program::lab
