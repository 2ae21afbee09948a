// Time to renew the surface field and the display mesh of a cut body, compared with building them
// again. The body is a box of 2 million voxels, rotated against its grid; a ball of 1,000 voxels is
// cut from the center of a face. The ratios matter.
#include <benchmark/benchmark.h>
#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/voxels/digitize.h>
#include <cloudcontact/voxels/display_mesh.h>
#include <cloudcontact/voxels/pieces.h>

#include <cmath>

#include "workpiece/cut_cases.h"

namespace {

using namespace cloudcontact;
using cloudcontact::testing::bite;

FieldSettings settings() {
  FieldSettings s;
  s.threads = 1;
  s.renewable = true;
  return s;
}

Mesh boxMesh(const Vec3& half, const Eigen::Quaterniond& turn) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back(
        turn * half.cwiseProduct(Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

struct Work {
  Cloud before, after;
  std::shared_ptr<const SurfaceField> field;

  Work() {
    const Vec3 half = 1e-3 * Vec3(64, 62, 63);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5, Vec3(1, 2, -1).normalized()));
    DigitizeSettings how;
    how.voxelSize = 1e-3;
    how.threads = 1;
    before = digitize(boxMesh(half, turn), how);
    // Two thirds of a ball of radius 7 lie in the body: about 1,000 voxels.
    const Vec3 center = (turn * Vec3(0, 0, half.z() - 2e-3) - before.origin()) / 1e-3;
    after = cutCloud(before, bite(before, center, 7, 12));
    field = SurfaceField::build(before, settings());
  }
};
const Work& work() {
  static const Work one;
  return one;
}

void countVoxels(benchmark::State& state) {
  state.counters["voxels"] = work().before.massProperties().volume / std::pow(1e-3, 3);
  state.counters["cut"] =
      (work().before.massProperties().volume - work().after.massProperties().volume) /
      std::pow(1e-3, 3);
}

void fieldBuilt(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(SurfaceField::build(work().after, settings()));
  countVoxels(state);
}
void fieldRenewed(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(renewed(work().field, work().after, settings()));
  countVoxels(state);
}
// The lower bound: copies and compares, but changes nothing.
void fieldCopied(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(renewed(work().field, work().before, settings()));
}
void meshMade(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(DisplayMesh(work().after, 1));
}
void meshRenewed(benchmark::State& state) {
  DisplayMesh mesh(work().before, 1);
  bool cut = false;
  for (auto _ : state)
    benchmark::DoNotOptimize(mesh.renew((cut = !cut) ? work().after : work().before));
}
void piecesFound(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(pieces(work().after));
}

BENCHMARK(fieldBuilt)->Unit(benchmark::kMillisecond);
BENCHMARK(fieldRenewed)->Unit(benchmark::kMillisecond);
BENCHMARK(fieldCopied)->Unit(benchmark::kMillisecond);
BENCHMARK(meshMade)->Unit(benchmark::kMillisecond);
BENCHMARK(meshRenewed)->Unit(benchmark::kMillisecond);
BENCHMARK(piecesFound)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
