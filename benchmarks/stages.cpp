// Time of each stage of a contact per sample, compared with reading the same bytes from memory in
// the same run. The pair is two equal tori, 20 voxels to the tube's radius, one voxel deep:
// thousands of hits on a curved band.
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <benchmark/benchmark.h>
#include <btBulletCollisionCommon.h>
#include <cloudcontact/bullet/cloud_contact.h>
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/voxels/digitize.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "contact/binner.h"
#include "contact/hit_search.h"
#include "kernels/contact/patch_force.h"
#include "torus.h"

namespace {

using namespace cloudcontact;

constexpr double kVoxel = 5e-4, kTube = 20 * kVoxel, kRing = 2.5 * kTube;
constexpr std::size_t kEnough = 1000;  // hits; enough to resolve the stages
constexpr double kCell = 8 * kVoxel;   // of a bin, as in ContactFinder

Mesh torus() {
  return torusMesh(kRing, kTube, 320, 128);
}

struct Pair {
  Cloud cloud;
  std::shared_ptr<const SurfaceField> field;
  ContactBody a, b;

  Pair() {
    DigitizeSettings settings;
    settings.voxelSize = kVoxel;
    settings.threads = 1;
    cloud = digitize(torus(), settings);
    field = SurfaceField::build(cloud);
    a.field = b.field = field.get();
    b.pose.position = {0.37 * kVoxel, 0.61 * kVoxel, 2 * kTube - kVoxel};
  }
};
const Pair& pair() {
  static const Pair one;
  return one;
}

struct Found {
  HitColumns hits;
  std::size_t samples = 0;  // looked up

  explicit Found(const Pair& p) {
    HitSearch search;
    search.run(p.a, p.b, frameOf(p.a, p.b), 0, kEnough, hits);
    samples = search.lookups();
  }
};

// A lookup reads a sample's position, normal and width, and the field's record.
constexpr double kLookUpBytes = 7 * sizeof(float) + sizeof(CcVoxel);
// It computes the transform (18), the grid cell (20), the plane (35) and the outcome (30).
constexpr double kLookUpOperations = 103;
// A hit is written and read with its key and its index in the order of bins.
constexpr double kHitBytes = 16 * sizeof(float) + 2, kKeyBytes = 5 * sizeof(float) + 8;
// 13 vectors of four, each a product and a sum, and their factors.
constexpr double kSumOperations = 130;

// Adds a column with the time per item.
void perItem(benchmark::State& state, const char* name, double count, double bytes,
             double operations = 0) {
  state.counters[name] = benchmark::Counter(
      count, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["count"] = count;
  if (bytes > 0) state.counters["bytes per item"] = bytes;
  if (operations > 0) state.counters["operations per item"] = operations;
}

void digitizing(benchmark::State& state) {
  const Mesh mesh = torus();
  DigitizeSettings settings;
  settings.voxelSize = kVoxel;
  settings.threads = 1;
  for (auto _ : state) benchmark::DoNotOptimize(digitize(mesh, settings));
  const VoxelCounts counts = pair().cloud.counts();
  perItem(state, "s per voxel", double(counts.inside + counts.interface), 1);
}

void baseVectors(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(SurfaceField::build(pair().cloud));
  perItem(state, "s per band voxel", double(pair().field->bandVoxels()), 0);
}

void testingSamples(benchmark::State& state) {
  const Pair& p = pair();
  HitSearch search;
  HitColumns hits;
  const PairFrame frame = frameOf(p.a, p.b);
  for (auto _ : state) {
    hits.clear();
    search.run(p.a, p.b, frame, 0, kEnough, hits);
  }
  perItem(state, "s per sample", double(search.lookups()), kLookUpBytes, kLookUpOperations);
  state.counters["hits"] = double(hits.size());
}

void clustering(benchmark::State& state) {
  const Found found(pair());
  Binner binner;
  for (auto _ : state) benchmark::DoNotOptimize(binner.patches(found.hits, kCell, false).data());
  perItem(state, "s per hit", double(found.hits.size()), kHitBytes + kKeyBytes, kSumOperations);
  state.counters["s per sample"] =
      benchmark::Counter(double(found.samples), benchmark::Counter::kIsIterationInvariantRate |
                                                    benchmark::Counter::kInvert);
}

void reducing(benchmark::State& state) {
  const Found found(pair());
  Binner binner;
  const std::vector<CcSums>& patches = binner.patches(found.hits, kCell, false);
  for (auto _ : state)
    for (const CcSums& sums : patches) {
      const auto* const patch = &sums;
      CcFlat flat{};
      const CcPatchForce force = ccForceOf(patch, false, false, kA, &flat);
      CcPlan plan = ccPlanOf(patch, &force, &flat, 0, kVoxel);
      benchmark::DoNotOptimize(plan);
    }
  perItem(state, "s per hit", double(found.hits.size()), 0);
}

void wholeContact(benchmark::State& state) {
  const Pair& p = pair();
  ContactFinder finder;
  std::size_t samples = 0;
  ContactSettings settings;
  settings.samples = kEnough;
  for (auto _ : state) samples = finder.find(p.a, p.b, settings).samples;
  perItem(state, "s per hit", double(samples), 0);
}

void manifold(benchmark::State& state) {
  const Pair& p = pair();
  CloudContactSettings settings{std::nullopt, kEnough};
  settings.reuseMotion = 0;  // every call searches
  CloudContact seam(settings);
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  seam.attach(dispatcher);
  CloudShape shape(p.field);
  btCollisionObject a, b;
  a.setCollisionShape(&shape);
  b.setCollisionShape(&shape);
  const Vec3& at = p.b.pose.position;
  const btVector3 place(btScalar(at.x()), btScalar(at.y()), btScalar(at.z()));
  b.setWorldTransform(btTransform(btQuaternion::getIdentity(), place));
  const btCollisionObjectWrapper first(nullptr, &shape, &a, a.getWorldTransform(), -1, -1);
  const btCollisionObjectWrapper second(nullptr, &shape, &b, b.getWorldTransform(), -1, -1);
  btCollisionAlgorithm* algorithm =
      dispatcher.findAlgorithm(&first, &second, nullptr, BT_CONTACT_POINT_ALGORITHMS);
  btManifoldResult result(&first, &second);
  btDispatcherInfo info;
  for (auto _ : state) algorithm->processCollision(&first, &second, info, &result);
  algorithm->~btCollisionAlgorithm();
  dispatcher.freeCollisionAlgorithm(algorithm);
}

// The lower bound of testing: only reads and sums the same bytes. The samples are contiguous, and
// their records follow each other roughly along the band, as the surface's voxels do.
void bareGather(benchmark::State& state) {
  const std::size_t samples = Found(pair()).samples, band = pair().field->bandVoxels();
  std::vector<CcVoxel> field(band, CcVoxel{1, 2});
  std::vector<float> columns[7];
  for (auto& c : columns) c.assign(samples, 1.0f);
  std::vector<std::uint32_t> where(samples);
  std::mt19937 random(1);
  for (std::size_t i = 0; i < samples; ++i)
    where[i] = std::uint32_t((i * band / samples + random() % 64) % band);
  for (auto _ : state) {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < samples; ++i) {
      const CcVoxel v = field[where[i]];
      float sample = 0;
      for (const auto& c : columns) sample += c[i];
      sum += v.a + v.b + (sample > 0);
    }
    benchmark::DoNotOptimize(sum);
  }
  perItem(state, "s per sample", double(samples), kLookUpBytes);
}

BENCHMARK(digitizing)->Unit(benchmark::kMillisecond);
BENCHMARK(baseVectors)->Unit(benchmark::kMillisecond);
BENCHMARK(bareGather)->Unit(benchmark::kMicrosecond);
BENCHMARK(testingSamples)->Unit(benchmark::kMicrosecond);
BENCHMARK(clustering)->Unit(benchmark::kMicrosecond);
BENCHMARK(reducing)->Unit(benchmark::kMicrosecond);
BENCHMARK(wholeContact)->Unit(benchmark::kMicrosecond);
BENCHMARK(manifold)->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
