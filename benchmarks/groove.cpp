// Time of every cut of a body in a Bullet world. A ball bur of 8 voxels' radius mills grooves, back
// and forth, into a box of 115,000 voxels that falls freely; it advances by 0.6 to 1 voxel a step.
// Then it parts the box, and a saw parts what is left in a single cut. All cuts are gradual: no
// call should hold a step for more than 5 ms. Beside it, the same cuts at once.
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

// Processor time of all threads [s], or wall time if fields use several.
template <typename Work>
double secondsOf(Work&& work) {
  const auto now = [] {
    timespec t;
    clock_gettime(threads == 1 ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC, &t);
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
  std::vector<double> fall;              // calls from the cut that parts it until a piece falls off
  std::vector<double> sever;             // the same of a saw's cut that halves the body
  int longest = 0;                       // bites until one is felt
  std::uint64_t hash = 0;
};

class Milling {
 public:
  Milling(bool gradual, Times& times)
      : gradual_(gradual), times_(times), body_(box(), btTransform::getIdentity(), settings()) {
    body_.addTo(world_.world);
  }

  void mill(int steps, double depth) {
    Path path{Vec3(-2, 9, kTop + kBur - depth)};
    for (int k = 0; k < steps; ++k) {
      path.advance(kAdvances[k % 3]);
      cut(bite(path.at, k % 2 ? 4 : 12), times_.cut);
      countBites();
      times_.step.push_back(secondsOf([&] { step(); }));
    }
    while (body_.behind() || body_.shape().field().unsettled() > 0)
      times_.quiet.push_back(secondsOf([&] { step(); }));
    times_.hash = body_.shape().field().hash();
  }

  // The bur goes to and fro across the box, deeper by 5 voxels each time, until a piece falls off.
  void part() {
    for (double z = kTop + 2; z > -10; z -= 5)
      for (double y = -4; y < 53; y += 0.9) {
        const std::vector<VoxelCut> cuts = bite(Vec3(75, y, z), 4);
        const bool parts = pieces(cutCloud(body_.cloud(), cuts)).size() > 1;
        if (cut(cuts, parts ? times_.fall : times_.part)) return;
        while (parts && body_.behind() && !goOn(times_.fall)) step();
        if (parts) return;
        step();
      }
  }

  void saw() {
    step();
    const std::vector<VoxelCut> cuts = cloudcontact::testing::sawn(body_.cloud(), 40, 41.5);
    cut(cuts, times_.sever);
    while (body_.behind()) step(), goOn(times_.sever);
  }

 private:
  static CuttableBodySettings settings() {
    CuttableBodySettings how;
    how.threads = threads;
    return how;
  }
  std::vector<VoxelCut> bite(const Vec3& at, int points) {
    return cloudcontact::testing::bite(body_.cloud(), at, kBur, points);
  }
  void countBites() {
    bites_ = felt_ == &body_.shape().field() && body_.behind() ? bites_ + 1 : 0;
    felt_ = &body_.shape().field();
    times_.longest = std::max(times_.longest, bites_);
  }
  void step() { world_.world.stepSimulation(btScalar(1e-3), 0); }
  // These return whether a piece fell off.
  bool cut(const std::vector<VoxelCut>& cuts, std::vector<double>& times) {
    CutOutcome outcome;
    times.push_back(
        secondsOf([&] { outcome = gradual_ ? body_.cutGradually(cuts) : body_.cut(cuts); }));
    return !outcome.fallen.empty();
  }
  bool goOn(std::vector<double>& times) {
    CutOutcome outcome;
    times.push_back(secondsOf([&] { outcome = body_.goOn(); }));
    return !outcome.fallen.empty();
  }

  bool gradual_;
  Times& times_;
  World world_;
  CuttableBody body_;
  const SurfaceField* felt_ = nullptr;
  int bites_ = 0;  // since then
};

Times mill(bool gradual, int steps, double depth) {
  Times times;
  Milling milling(gradual, times);
  milling.mill(steps, depth);
  milling.part();
  milling.saw();
  return times;
}

void keepLeast(std::vector<double>& least, const std::vector<double>& more) {
  for (std::size_t k = 0; k < least.size(); ++k) least[k] = std::min(least[k], more[k]);
}

void report(const char* what, const std::vector<double>& times) {
  if (times.empty()) return;
  double sum = 0, worst = 0;
  for (const double t : times) sum += t, worst = std::max(worst, t);
  std::printf("%-24s mean %5.2f  median %5.2f  worst %5.2f ms over %zu calls\n", what,
              1e3 * sum / double(times.size()), 1e3 * median(times), 1e3 * worst, times.size());
}

int run(bool gradual, int steps, double depth, int repeats) {
  Times least = mill(gradual, steps, depth);
  for (int k = 1; k < repeats; ++k) {
    const Times more = mill(gradual, steps, depth);
    if (more.hash != least.hash) return std::puts("runs differ"), 1;
    keepLeast(least.cut, more.cut);
    keepLeast(least.step, more.step);
    keepLeast(least.quiet, more.quiet);
    keepLeast(least.part, more.part);
    keepLeast(least.fall, more.fall);
    keepLeast(least.sever, more.sever);
  }
  std::printf("%s, %d steps behind\n", gradual ? "gradual cuts" : "cuts at once", least.longest);
  report("  bites", least.cut);
  report("  world's step, cutting", least.step);
  report("  world's step, settling", least.quiet);
  report("  bites, parting", least.part);
  report("  until a piece falls", least.fall);
  report("  sawn through", least.sever);
  return 0;
}

}  // namespace

int main(int count, char** values) {
  const int steps = count > 1 ? std::atoi(values[1]) : 300;
  const double depth = count > 2 ? std::atof(values[2]) : 6;
  const int repeats = count > 3 ? std::atoi(values[3]) : 5;
  threads = count > 4 ? std::atoi(values[4]) : 1;
  std::printf("%.0f voxels\n", 1e9 * box().massProperties().volume);
  return run(true, steps, depth, repeats) || run(false, steps, depth, repeats);
}
