// Errors of contacts over many grids and poses.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "contact/contact_cases.h"

namespace cloudcontact::testing {
namespace {

// Depth of the patch with the largest force.
double heaviestDepth(const ContactResult& found) {
  double force = -1, depth = 0;
  for (const Patch& patch : found.patches) {
    if (patch.stiffness * patch.depth <= force) continue;
    force = patch.stiffness * patch.depth;
    depth = patch.depth;
  }
  return depth;
}

void add(ContactErrors& sum, const ContactErrors& e) {
  sum.normalDeg += e.normalDeg;
  sum.depth += std::abs(e.depth);
  sum.center += e.center;
  sum.forceRelative += std::abs(e.forceRelative);
  sum.spin += std::abs(e.spin);
  sum.patches += e.patches;
  sum.points += e.points;
  sum.samples += e.samples;
}

void raise(ContactErrors& worst, const ContactErrors& e) {
  worst.normalDeg = std::max(worst.normalDeg, e.normalDeg);
  worst.depth = std::max(worst.depth, std::abs(e.depth));
  worst.center = std::max(worst.center, e.center);
  worst.forceRelative = std::max(worst.forceRelative, std::abs(e.forceRelative));
  worst.spin = std::max(worst.spin, std::abs(e.spin));
  worst.patches = std::max(worst.patches, e.patches);
  worst.points = std::max(worst.points, e.points);
  worst.samples = std::max(worst.samples, e.samples);
}

void finish(ErrorSummary& summary) {
  const double n = summary.runs;
  ContactErrors& mean = summary.mean;
  mean.normalDeg /= n;
  mean.depth /= n;
  mean.center /= n;
  mean.forceRelative /= n;
  mean.spin /= n;
  const auto rounded = [n](std::size_t sum) {
    return static_cast<std::size_t>(std::lround(static_cast<double>(sum) / n));
  };
  mean.patches = rounded(mean.patches);
  mean.points = rounded(mean.points);
  mean.samples = rounded(mean.samples);
  summary.depthBias /= n;
  summary.forceBias /= n;
}

ContactErrors zeroErrors() {
  return {0, 0, 0, 0, 0, 0, 0, 0};
}

}  // namespace

double Truth::force(const ContactSettings& settings) const {
  const bool foundation = std::holds_alternative<Foundation>(settings.law);
  return sharedSpring(settings.law).stiffness * (foundation ? volume : depth);
}

ContactErrors compare(const ContactResult& found, const Truth& truth, const Pose& world,
                      const ContactSettings& settings, double voxel) {
  ContactErrors errors;
  errors.patches = found.patches.size();
  errors.points = found.points.size();
  errors.samples = found.samples;
  errors.depth = (heaviestDepth(found) - truth.depth) / voxel;
  const Wrench wrench = wrenchOnB(found, {}, {});
  const double force = wrench.force.norm();
  if (!(force > 0)) return errors;
  const Vec3 normal = world.orientation * truth.normal;
  const Vec3 direction = wrench.force / force;
  errors.normalDeg =
      std::atan2(direction.cross(normal).norm(), direction.dot(normal)) * 180 / std::numbers::pi;
  const Vec3 moment = wrench.torque - world.toWorld(truth.center).cross(wrench.force);
  errors.center = direction.cross(moment).norm() / force / voxel;
  errors.spin = direction.dot(moment) / force / voxel;
  errors.forceRelative = force / truth.force(settings) - 1;
  return errors;
}

ContactResult findContact(ContactFinder& finder, const Instance& instance, const Placed& placed,
                          const Pose& world, const ContactSettings& settings, bool swapped) {
  const ContactBody a = instance.a.at(world * placed.a), b = instance.b.at(world * placed.b);
  return swapped ? finder.find(b, a, settings) : finder.find(a, b, settings);
}

std::vector<ErrorSummary> runCase(const ContactCase& one, const std::vector<double>& depths,
                                  const RunSettings& settings) {
  std::vector<ErrorSummary> summaries(depths.size());
  for (ErrorSummary& summary : summaries) summary.mean = summary.worst = zeroErrors();
  BodyMaker maker{settings.voxel, Random(settings.seed), settings.field};
  ContactFinder finder;
  for (int k = 0; k < settings.instances; ++k) {
    const Instance instance = one.make(maker);
    const Pose world{maker.random.rotation(), 100 * settings.voxel * maker.random.inCube()};
    for (std::size_t i = 0; i < depths.size(); ++i) {
      const Placed placed = instance.place(depths[i] * settings.voxel);
      const ContactResult& found = findContact(finder, instance, placed, world, settings.contact);
      const ContactErrors errors =
          compare(found, placed.truth, world, settings.contact, settings.voxel);
      ErrorSummary& summary = summaries[i];
      ++summary.runs;
      if (found.points.empty()) ++summary.missed;
      summary.depthBias += errors.depth;
      summary.forceBias += errors.forceRelative;
      add(summary.mean, errors);
      raise(summary.worst, errors);
    }
  }
  for (ErrorSummary& summary : summaries) finish(summary);
  return summaries;
}

}  // namespace cloudcontact::testing
