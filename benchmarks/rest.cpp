// Piles of bricks and nuts that rest without sleeping. Compares two narrow phases in one run: a
// search in every step, and contacts reused between steps (CloudContactSettings::reuseMotion).
//   rest [--bodies N] [--seconds S] [--settle S] [--threads N] [--voxel H] [--motion VOXELS]
// A pile is poured, or laid in layers, and settles. Two copies of it then run for the given time.
// Beside the times the table shows how far the bodies have gone meanwhile in each copy, and how far
// apart they are in the two.
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/voxels/digitize.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <stdexcept>
#include <string>

#include "command.h"
#include "nuts.h"
#include "scene/primitive_mesh.h"

namespace {

using namespace cloudcontact;

struct Options {
  int bodies = 200, threads = 1;
  bool nuts = false;
  double seconds = 60, settle = 4, voxel = 1e-3, motion = 0.02;
};

constexpr double kSteps = 240;  // a second
constexpr double kBrick = 20e-3, kPitch = 21e-3;
constexpr int kRows = 4;

int steps(double seconds) {
  return static_cast<int>(kSteps * seconds);
}

double most(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

// How far each body is from where it is in `poses` [m].
std::vector<double> away(const Heap& heap, const std::vector<Pose>& poses) {
  std::vector<double> all;
  for (std::size_t i = 0; i < poses.size(); ++i)
    all.push_back((heap.pose(static_cast<int>(i)).position - poses[i].position).norm());
  return all;
}

std::vector<Pose> posesOf(const Heap& heap, int bodies) {
  std::vector<Pose> poses;
  for (int i = 0; i < bodies; ++i) poses.push_back(heap.pose(i));
  return poses;
}

void compare(const char* name, const Options& options, HeapSettings settings) {
  settings.contact.reuseMotion = 0;
  Heap settled(settings);
  settled.run(steps(options.settle), 1);
  const std::vector<Pose> start = posesOf(settled, options.bodies);
  std::vector<Pose> ends[2];
  double times[2];
  for (const bool reuse : {false, true}) {
    settings.contact.reuseMotion = reuse ? options.motion : 0;
    Heap heap(settings);
    heap.rest(settled);
    const double energy = heap.energy();
    const HeapRow row = heap.run(0, steps(options.seconds));
    const CloudContactStatistics made = heap.statistics();
    const std::vector<double> gone = away(heap, start);
    times[reuse] = row.narrowSeconds;
    ends[reuse] = posesOf(heap, options.bodies);
    std::printf(
        "%-7s %-7s narrow %8.1f us, step %8.1f us, %5.0f pairs touch of %5.0f, %5.1f%% moved; "
        "median %.4f, most %.4f voxel away; energy %+.3g J, fastest %.4f voxel a step\n",
        name, reuse ? "moved" : "fresh", 1e6 * row.narrowSeconds, 1e6 * row.stepSeconds, row.pairs,
        row.overlaps, 100. * double(made.reused) / double(std::max<std::size_t>(1, made.pairs)),
        [&] {
          auto sorted = gone;
          std::sort(sorted.begin(), sorted.end());
          return sorted[sorted.size() / 2];
        }() /
            options.voxel,
        most(gone) / options.voxel, heap.energy() - energy,
        heap.fastest() / kSteps / options.voxel);
    if (reuse)
      std::printf("%-7s ratio of narrow phases %.3f; the two are %.4f voxel apart at most\n", name,
                  times[1] / times[0], most(away(heap, ends[0])) / options.voxel);
    std::fflush(stdout);
  }
}

std::function<std::shared_ptr<btCollisionShape>()> shapesOf(const Mesh& mesh, double voxel) {
  DigitizeSettings how;
  how.voxelSize = voxel;
  const auto field = SurfaceField::build(digitize(mesh, how));
  return [field] { return std::make_shared<CloudShape>(field); };
}

// Walls of bricks, each brick on two others: pyramids of kRows rows.
std::vector<btTransform> walls(int bodies) {
  std::vector<btTransform> places;
  for (int wall = 0;; ++wall)
    for (int row = 0; row < kRows; ++row)
      for (int i = 0; i < kRows - row; ++i) {
        if (static_cast<int>(places.size()) == bodies) return places;
        places.emplace_back(
            btQuaternion::getIdentity(),
            btVector3(btScalar(kPitch * (i + 0.5 * row)), btScalar(2 * kBrick * wall),
                      btScalar(kNutHeight * (row + 0.5))));
      }
}

void measure(const Options& options) {
  HeapSettings settings = nutHeap(options.bodies, options.voxel, options.threads);
  settings.contact.bears = 100;
  settings.newton = true;
  settings.poured = true;
  settings.shape = shapesOf(nut(), options.voxel);
  if (options.nuts) return compare("nuts", options, settings);
  settings.shape =
      shapesOf(program::primitiveMesh(Box{{kBrick / 2, kBrick / 2, kNutHeight / 2}}, options.voxel),
               options.voxel);
  settings.places = walls(options.bodies);
  compare("bricks", options, settings);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App words("Piles at rest", "rest");
  words.add_option("--bodies", options.bodies);
  words.add_option("--seconds", options.seconds);
  words.add_option("--settle", options.settle, "[s] before the clock starts");
  words.add_option("--threads", options.threads);
  words.add_option("--voxel", options.voxel, "[m]");
  words.add_option("--nuts", options.nuts, "0: walls of bricks");
  words.add_option("--motion", options.motion, "of bodies whose contacts move with them [voxels]");
  return runCommand(words, argc, argv, [&options] { measure(options); });
}
