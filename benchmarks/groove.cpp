// Time of every cut of a body in a Bullet world. A ball bur of 8 voxels' radius mills grooves, back
// and forth, into a box of 115,000 voxels that falls freely; it advances by 0.6 to 1 voxel a step.
// Which voxels the bur takes is not timed. All is done several times, always the same to the bit,
// and of each step the least time counts: what other programs add is no part of it.
//
// groove [steps] [depth of the groove in voxels] [times] [threads]
//
// With more than one thread, wall time.
#include <btBulletDynamicsCommon.h>
#include <cloudcontact/bullet/cuttable_body.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "timing.h"
#include "workpiece/cut_cases.h"

namespace {

using namespace cloudcontact;

constexpr double kBur = 8;                      // radius [voxels]
constexpr double kAdvances[] = {1, 0.6, 0.85};  // of the bur [voxels a step]
constexpr double kTop = 33.7;                   // of the box [voxels]
int threads = 1;                                // for fields; 0: all cores

// The bur's center, back and forth in rows 1.2 radii apart.
struct Path {
  Vec3 at;
  double way = 1;

  void advance(double by) {
    at.x() += way * by;
    if (at.x() > -kBur && at.x() < 113) return;
    way = -way;
    at.y() += 1.2 * kBur;
  }
};

Cloud box() {
  const Vec3 low(4.3, 4.2, 4.1), high(100.6, 44.4, kTop);
  const auto inside = [=](const Vec3& p) {
    return (p.array() > low.array()).all() && (p.array() < high.array()).all();
  };
  return cloudcontact::testing::cloudOf(inside, {14, 7, 5}, 1e-3);
}

// Processor time of this thread [s], or wall time if there are several.
template <typename Work>
double threadSeconds(Work&& work) {
  const auto now = [] {
    timespec t;
    clock_gettime(threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
  };
  const double start = now();
  work();
  return now() - start;
}

struct World {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
};

struct Times {
  std::vector<double> cut, step, quiet;  // quiet: steps after the cuts, until the field is settled
  std::vector<double> part;              // cuts of the bur as it parts the body
  std::vector<double> fall;              // the one in which a piece falls off
  std::vector<double> sever;             // a saw's cut that halves the body at once
  std::uint64_t hash = 0;
};

// The bur goes to and fro across the box, deeper by 5 voxels each time, until a piece falls off.
template <typename Step>
void part(CuttableBody& body, Times& times, Step&& step) {
  for (double z = kTop + 2; z > -10; z -= 5)
    for (double y = -4; y < 53; y += 0.9) {
      const std::vector<VoxelCut> cuts =
          cloudcontact::testing::bite(body.cloud(), Vec3(75, y, z), kBur, 4);
      CutOutcome outcome;
      const double time = threadSeconds([&] { outcome = body.cut(cuts); });
      (outcome.fallen.empty() ? times.part : times.fall).push_back(time);
      if (!outcome.fallen.empty()) return;
      step();
    }
}

Times mill(int steps, double depth) {
  CuttableBodySettings settings;
  settings.threads = threads;
  World world;
  CuttableBody body(box(), btTransform::getIdentity(), settings);
  body.addTo(world.world);
  const auto step = [&] { world.world.stepSimulation(btScalar(1e-3), 0); };
  Path path{Vec3(-2, 9, kTop + kBur - depth)};
  Times times;
  for (int k = 0; k < steps; ++k) {
    path.advance(kAdvances[k % 3]);
    const std::vector<VoxelCut> cuts =
        cloudcontact::testing::bite(body.cloud(), path.at, kBur, k % 2 ? 4 : 12);
    times.cut.push_back(threadSeconds([&] { body.cut(cuts); }));
    times.step.push_back(threadSeconds(step));
  }
  while (body.shape().field().unsettled() > 0) times.quiet.push_back(threadSeconds(step));
  times.hash = body.shape().field().hash();
  part(body, times, step);
  const std::vector<VoxelCut> saw = cloudcontact::testing::sawn(body.cloud(), 40, 41.5);
  times.sever.push_back(threadSeconds([&] { body.cut(saw); }));
  return times;
}

void keepLeast(std::vector<double>& least, const std::vector<double>& more) {
  for (std::size_t k = 0; k < least.size(); ++k) least[k] = std::min(least[k], more[k]);
}

void report(const char* what, const std::vector<double>& times) {
  if (times.empty()) return;
  double sum = 0, worst = 0;
  for (const double t : times) sum += t, worst = std::max(worst, t);
  std::printf("%-24s mean %5.2f  median %5.2f  worst %5.2f ms over %zu steps\n", what,
              1e3 * sum / double(times.size()), 1e3 * median(times), 1e3 * worst, times.size());
}

}  // namespace

int main(int count, char** values) {
  const int steps = count > 1 ? std::atoi(values[1]) : 300;
  const double depth = count > 2 ? std::atof(values[2]) : 6;
  const int repeats = count > 3 ? std::atoi(values[3]) : 5;
  threads = count > 4 ? std::atoi(values[4]) : 1;
  std::printf("%.0f voxels\n", 1e9 * box().massProperties().volume);
  Times least = mill(steps, depth);
  for (int k = 1; k < repeats; ++k) {
    const Times more = mill(steps, depth);
    if (more.hash != least.hash) return std::puts("runs differ"), 1;
    keepLeast(least.cut, more.cut);
    keepLeast(least.step, more.step);
    keepLeast(least.quiet, more.quiet);
    keepLeast(least.part, more.part);
    keepLeast(least.fall, more.fall);
    keepLeast(least.sever, more.sever);
  }
  report("cut()", least.cut);
  report("world's step, cutting", least.step);
  report("world's step, settling", least.quiet);
  report("cut(), parting", least.part);
  report("cut(), a piece falls", least.fall);
  report("sawn through at once", least.sever);
}
