// Time of a step's narrow phase with Bullet's dispatcher (0 threads) and with CloudDispatcher on 1,
// 2 and 4 threads: 200 pairs, and one large pair. The ratios matter.
#include <benchmark/benchmark.h>
#include <btBulletDynamicsCommon.h>
#include <cloudcontact/bullet/cloud_contact.h>
#include <cloudcontact/bullet/cloud_dispatcher.h>
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/voxels/digitize.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "torus.h"

namespace {

using namespace cloudcontact;

// Built once for all runs, because the large field takes half a minute.
std::shared_ptr<const SurfaceField> fieldOf(double tube, double voxel) {
  static std::map<double, std::shared_ptr<const SurfaceField>> known;
  auto& field = known[tube];
  if (field) return field;
  DigitizeSettings settings;
  settings.voxelSize = voxel;
  const double radius = tube * voxel;
  return field = SurfaceField::build(digitize(torusMesh(2.5 * radius, radius, 320, 128), settings));
}

// Bodies at rest, pressed together in pairs, whose contacts Bullet searches again in each run.
class Pairs {
 public:
  // Pairs of equal tori whose tubes have a radius of `tube` voxels. 0 threads: Bullet's dispatcher.
  Pairs(int threads, int count, double tube, const CloudContactSettings& settings)
      : contact_(settings), dispatcher_(make(threads)) {
    contact_.attach(*dispatcher_);
    // The broad phase enlarges all boxes by 7 cm.
    const double voxel = 1e-3, radius = tube * voxel, apart = 8 * radius + 0.2;
    shape_ = std::make_unique<CloudShape>(fieldOf(tube, voxel));
    for (int i = 0; i < count; ++i)
      for (const double up : {0.0, 2 * radius - voxel}) {
        auto& body = *bodies_.emplace_back(std::make_unique<btRigidBody>(
            btRigidBody::btRigidBodyConstructionInfo(1, nullptr, shape_.get(), {1, 1, 1})));
        const double aside = 0.37 * voxel * std::sin(i) * (up > 0);
        body.setCenterOfMassTransform(btTransform(
            btQuaternion::getIdentity(), btVector3(btScalar(apart * (i % 16) + aside),
                                                   btScalar(apart * (i / 16)), btScalar(up))));
        body.setActivationState(DISABLE_DEACTIVATION);
        world_.addRigidBody(&body);
      }
  }
  ~Pairs() {
    for (auto& body : bodies_) world_.removeRigidBody(body.get());
  }

  void step() { world_.performDiscreteCollisionDetection(); }
  const CloudContact& contact() const { return contact_; }

 private:
  std::unique_ptr<btCollisionDispatcher> make(int threads) {
    if (threads == 0) return std::make_unique<btCollisionDispatcher>(&configuration_);
    return std::make_unique<CloudDispatcher>(&configuration_, threads);
  }

  CloudContact contact_;
  btDefaultCollisionConfiguration configuration_;
  std::unique_ptr<btCollisionDispatcher> dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{dispatcher_.get(), &broadphase_, &solver_, &configuration_};
  std::unique_ptr<CloudShape> shape_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

void run(benchmark::State& state, int count, double tube, const CloudContactSettings& settings) {
  Pairs pairs(static_cast<int>(state.range(0)), count, tube, settings);
  pairs.step();
  std::size_t steps = 1;
  for (auto _ : state) {
    pairs.step();
    ++steps;
  }
  const CloudContactStatistics statistics = pairs.contact().statistics();
  state.counters["pairs"] = double(statistics.pairs) / double(steps);
  state.counters["hits a pair"] = double(statistics.samples) / double(statistics.pairs);
}

CloudContactSettings searching() {
  CloudContactSettings settings;
  settings.reuseMotion = 0;
  return settings;
}

void twoHundredPairs(benchmark::State& state) {
  run(state, 200, 10, searching());
}
void oneLargePair(benchmark::State& state) {
  // The foundation's law uses all samples.
  CloudContactSettings settings = searching();
  settings.law = Foundation{1e9, 1e5};
  run(state, 1, 40, settings);
}

// The minimum of many runs suffers least from a busy machine: --benchmark_repetitions=100.
double least(const std::vector<double>& times) {
  return *std::min_element(times.begin(), times.end());
}

void onThreads(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgName("threads")->Arg(0)->Arg(1)->Arg(2)->Arg(4);
  benchmark->UseRealTime()->Unit(benchmark::kMicrosecond)->ComputeStatistics("min", least);
}

BENCHMARK(twoHundredPairs)->Apply(onThreads);
BENCHMARK(oneLargePair)->Apply(onThreads);

}  // namespace

BENCHMARK_MAIN();
