// Bodies that nearly touch, beside the same bodies pressed: an M16 nut in its play, a peg centered
// in its hole. Each moves at random by up to a part of a voxel a query. Processor time of one
// thread; the samples that were looked up; the gap that was found, against that of all samples.
//
// near [queries] [voxel in mm]
#include <cloudcontact/contact/contact_finder.h>

#include <cstdio>
#include <cstdlib>
#include <random>

#include "field/mesh_field.h"
#include "scene/generated_mesh.h"
#include "timing.h"

namespace {

using namespace cloudcontact;

struct Pair {
  const char* name;
  std::shared_ptr<const SurfaceField> fixed, moving;
  Vec3 centered, pressed;  // places of the moving body
  double play;             // [m] it moves about `centered` by this much
};

struct Run {
  std::vector<double> micros, lookups;
  int touching = 0, missed = 0;  // missed: touches that all samples have
  std::vector<double> gaps;      // [m] beyond those of all samples
  double first = 0;
};

// Depth of the deepest of all samples of one body in the other [m].
double deepestOf(const SurfaceField& samples, const SurfaceField& other, const Pose& toOther) {
  double deepest = -1e30;
  const Cloud& cloud = samples.cloud();
  for (std::size_t k = 0; k < samples.sampleCount(); ++k) {
    const SurfaceSample s = samples.sample(k);
    const Vec3 at(s.position[0], s.position[1], s.position[2]);
    const auto there = other.at(toOther.toWorld(cloud.origin() + cloud.voxelSize() * at));
    if (there) deepest = std::max(deepest, there->depth);
  }
  return deepest;
}

double deepestOfAll(const ContactBody& a, const ContactBody& b) {
  const Pose bInA = a.pose.inverse() * b.pose;
  return std::max(deepestOf(*b.field, *a.field, bInA),
                  deepestOf(*a.field, *b.field, bInA.inverse()));
}

// `step`: the largest motion of a query [m]; turns by as much at a radius of 8 mm.
Run run(const Pair& pair, const Vec3& about, double play, double step, int queries) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> part(-1, 1);
  ContactFinder finder;
  ContactSettings settings;
  settings.margin = pair.fixed->cloud().voxelSize();
  ContactBody a, b;
  a.field = pair.fixed.get();
  b.field = pair.moving.get();
  Vec3 aside = Vec3::Zero(), turn = Vec3::Zero();
  Run result;
  for (int k = 0; k < queries; ++k) {
    for (int i = 0; i < 3; ++i) {
      aside[i] = std::clamp(aside[i] + step * part(random) / 2, -play, play);
      turn[i] = std::clamp(turn[i] + step * part(random) / 2, -play, play);
    }
    const Vec3 by = turn / 8e-3;
    b.pose.position = about + aside;
    b.pose.orientation = by.norm() > 0
                             ? Eigen::Quaterniond(Eigen::AngleAxisd(by.norm(), by.normalized()))
                             : Eigen::Quaterniond::Identity();
    const double start = threadSeconds();
    const ContactResult& contact = finder.find(a, b, settings);
    const double time = 1e6 * (threadSeconds() - start);
    if (k == 0) result.first = time;
    result.micros.push_back(time);
    result.lookups.push_back(double(finder.sampleLookups()));
    double depth = -settings.margin;
    for (const ContactPoint& p : contact.points) depth = std::max(depth, p.depth);
    result.touching += depth > 0;
    if (k % 20) continue;
    const double truth = deepestOfAll(a, b);
    result.missed += truth > 0 && depth <= 0;
    if (truth < 0 && truth > -settings.margin) result.gaps.push_back(truth - depth);
  }
  return result;
}

void report(const char* name, const char* how, double step, double voxel, Run r) {
  std::sort(r.micros.begin(), r.micros.end());
  std::printf(
      "%-5s %-8s %5.3f voxel  first %8.1f  median %8.1f  p99 %8.1f  worst %8.1f us, "
      "lookups %8.0f, touching %d of %zu, missed %d, gap off by %.3f, %.3f at most\n",
      name, how, step, r.first, median(r.micros), r.micros[r.micros.size() * 99 / 100],
      r.micros.back(), median(r.lookups), r.touching, r.micros.size(), r.missed,
      r.gaps.empty() ? 0 : median(r.gaps) / voxel,
      r.gaps.empty() ? 0 : *std::max_element(r.gaps.begin(), r.gaps.end()) / voxel);
}

}  // namespace

int main(int count, char** values) {
  const int queries = count > 1 ? std::atoi(values[1]) : 1000;
  const double voxel = 1e-3 * (count > 2 ? std::atof(values[2]) : 0.25);
  program::Thread thread;
  thread.clearance = 0.15e-3;
  const Pair pairs[] = {
      {"nut", testing::fieldOf(program::boltMesh(thread, 40e-3), voxel),
       testing::fieldOf(program::nutMesh(thread, 13e-3, 24e-3), voxel), Vec3(0, 0, 12e-3),
       Vec3(0, 0, 12e-3 - 0.1e-3 / std::sin(0.5236) - 0.26 * voxel), 0.02e-3},
      {"peg", testing::fieldOf(program::holeMesh(4.1e-3, 20e-3, 20e-3, 0.5e-3), voxel),
       testing::fieldOf(program::pegMesh(4e-3, 25e-3, 0.5e-3), voxel), Vec3(0, 0, 4e-3),
       Vec3(0.1e-3 + 0.26 * voxel, 0, 4e-3), 0.01e-3}};
  for (const Pair& pair : pairs) {
    report(pair.name, "pressed", 0.01, voxel,
           run(pair, pair.pressed, 0.1 * voxel, 0.01 * voxel, queries));
    for (const double step : {0.001, 0.01, 0.1})
      report(pair.name, "near", step, voxel,
             run(pair, pair.centered, pair.play, step * voxel, queries));
  }
}
