// A step's narrow phase on 200 pairs, by Bullet's own dispatcher and by CloudDispatcher on one, two
// and more threads, and on one large pair alone: `dispatcher`. The ratios are what is asked for.
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

// Built once for all runs: the large one takes half a minute.
std::shared_ptr<const SurfaceField> fieldOf(double tube, double voxel) {
  static std::map<double, std::shared_ptr<const SurfaceField>> known;
  auto& field = known[tube];
  if (field) return field;
  DigitizeSettings settings;
  settings.voxelSize = voxel;
  const double radius = tube * voxel;
  return field = SurfaceField::build(digitize(torusMesh(2.5 * radius, radius, 320, 128), settings));
}

// Bodies that stand still, pressed together in pairs; Bullet looks for their contacts again and
// again.
class Pairs {
 public:
  // 0 threads: Bullet's own dispatcher. Tori on their twins, `tube` voxels to a tube's radius.
  Pairs(int threads, int count, double tube, const CloudContactSettings& settings)
      : contact_(settings), dispatcher_(make(threads)) {
    contact_.attach(*dispatcher_);
    // Far enough apart for Bullet's broadphase, which makes all boxes wider by 7 cm.
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

  void look() { world_.performDiscreteCollisionDetection(); }
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
  pairs.look();
  std::size_t looks = 1;
  for (auto _ : state) {
    pairs.look();
    ++looks;
  }
  const CloudContactStatistics statistics = pairs.contact().statistics();
  state.counters["pairs"] = double(statistics.pairs) / double(looks);
  state.counters["hits a pair"] = double(statistics.samples) / double(statistics.pairs);
}

void twoHundredPairs(benchmark::State& state) {
  run(state, 200, 10, {});
}
void oneLargePair(benchmark::State& state) {
  // By the foundation's law all samples count.
  CloudContactSettings settings;
  settings.law = Foundation{1e9, 1e5};
  run(state, 1, 40, settings);
}

// The least of many runs is what a busy machine spoils least: --benchmark_repetitions=100.
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
