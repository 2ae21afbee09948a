// Voxels by quadrics: of samples that face a smooth surface of the other body.
#include <algorithm>
#include <bit>

#include "base/simd.h"
#include "contact/sixteen.h"
#include "contact/voxel_sums.h"

namespace cloudcontact {

namespace {

using search::TouchedSample;
using search::V3;

constexpr float kFaces = 0.7f;  // cosine: samples that face the other surface

// Adds the first `count` of sixteen voxels, whose depths a quadric tells, to the sums.
[[gnu::always_inline]] inline void addSixteen(const OwnedVoxel* voxels,
                                              const OwnedVectors::Level& vectors,
                                              std::uint32_t first, int count,
                                              const search::DepthQuadric& q, Sixteen* sum) {
  float x[16], y[16], z[16], share[16];
  CC_INDEPENDENT
  for (int i = 0; i < 16; ++i) {
    x[i] = voxels[i].x(), y[i] = voxels[i].y(), z[i] = voxels[i].z();
    const float u = x[i] - q.at[0], v = y[i] - q.at[1], w = z[i] - q.at[2];
    const float bend =
        u * (q.h[0] * u + q.h[3] * v + q.h[4] * w) + v * (q.h[1] * v + q.h[5] * w) + q.h[2] * w * w;
    const float depth = q.depth - (q.n[0] * u + q.n[1] * v + q.n[2] * w) - bend;
    const float part = ccMin(ccMax(depth + 0.5f, 0.0f), 1.0f) * voxels[i].coverage();
    share[i] = i < count ? part : 0.0f;
  }
  Sixteen s, a, b, c, f, g, h, l;
  load(share, s), load(x, a), load(y, b), load(z, c);
  load(&vectors.x[first], f), load(&vectors.y[first], g), load(&vectors.z[first], h);
  load(&vectors.length[first], l);
  f *= s, g *= s, h *= s, l *= s;
  sum[0] += s;
  sum[4] += f, sum[5] += g, sum[6] += h;
  sum[7] += b * h - c * g;
  sum[8] += c * f - a * h;
  sum[9] += a * g - b * f;
  sum[10] += l;
}

}  // namespace

bool VoxelSums::maySmooth(const TouchedSample& touched) const {
  if (!touched.plain) return false;
  V3 n;
  ccTurnBack(dir_->turnToOther, touched.other.data(), n.data());
  return -n.dot(V3(level_->runs[touched.sample].normal)) > kFaces;
}

void VoxelSums::addSmooth(const TouchedSample& touched) {
  smooth_.add(*dir_, *level_, touched);
  const OwnedRun& run = level_->runs[touched.sample];
  const OwnedVectors::Level& f = vectors_->levels[kLevels - 1];
  for (const std::uint32_t i : {run.first, run.first + 16}) {
    __builtin_prefetch(&level_->voxels[i]);
    __builtin_prefetch(&level_->voxels[i + 8]);
    __builtin_prefetch(&f.x[i]), __builtin_prefetch(&f.y[i]), __builtin_prefetch(&f.z[i]);
    __builtin_prefetch(&f.length[i]);
  }
  __builtin_prefetch(&level_->boxes.x[run.box]), __builtin_prefetch(&level_->boxes.y[run.box]);
  __builtin_prefetch(&level_->boxes.z[run.box]), __builtin_prefetch(&level_->boxes.halfX[run.box]);
  __builtin_prefetch(&level_->boxes.halfY[run.box]);
  __builtin_prefetch(&level_->boxes.halfZ[run.box]);
  if (smooth_.full()) sumSmooth();
}

void VoxelSums::sumSmooth() {
  if (smooth_.count == 0) return;
  smooth_.findQuadrics(*dir_, other_->field->data());
  lookups_ += static_cast<std::size_t>(4 * smooth_.count);
  for (int i = 0; i < smooth_.count; ++i) {
    const TouchedSample& touched = smooth_.touched[i];
    if (!smooth_.quadric[i].smooth) {
      addByLooks(touched);
      continue;
    }
    const std::size_t patch = patchAt(touched);
    if (patch != smoothPatch_) giveSmooth();
    smoothPatch_ = patch;
    addByQuadric(level_->runs[touched.sample], smooth_.quadric[i]);
  }
  giveSmooth();
  smooth_.count = 0;
}

// Gives what was summed by quadrics to its patch.
void VoxelSums::giveSmooth() {
  const double weight = ccWeightOf(1, hardness_[0], ability_);
  Lanes8* const to = sums_[smoothPatch_].hard;
  for (int k = 0; k < kTerms; ++k)
    for (int lane = 0; lane < kAtOnce; ++lane)
      to[k][lane % 8] += (k > kWeight ? weight : 1) * double(smoothSum_[k][lane]);
  for (int lane = 0; lane < kAtOnce; ++lane)
    to[kWeight][lane % 8] += weight * double(smoothSum_[kCount][lane]);
  std::memset(smoothSum_, 0, sizeof smoothSum_);
}

// Sixteen voxels at once, in a fixed order.
CC_LANES void VoxelSums::addByQuadric(const OwnedRun& run, const search::DepthQuadric& quadric) {
  const search::DepthQuadric q = quadric;
  const OwnedVectors::Level& vectors = vectors_->levels[kLevels - 1];
  const float here = q.depth + q.n[0] * q.at[0] + q.n[1] * q.at[1] + q.n[2] * q.at[2];
  const search::OwnedPlane plane{q.n[0], q.n[1], q.n[2], here, kLeast};
  Sixteen sum[kTerms];
  for (int k = 0; k < kTerms; ++k) load(smoothSum_[k], sum[k]);
  const std::uint32_t boxes = (run.size() + kAtOnce - 1) / kAtOnce;
  for (std::uint32_t b = 0; b < boxes; b += kAtOnce) {
    const int some = static_cast<int>(std::min<std::uint32_t>(kAtOnce, boxes - b));
    for (std::uint32_t below = search::boxesBelow(plane, level_->boxes, run.box + b, some); below;
         below &= below - 1) {
      const std::uint32_t first =
          run.first + kAtOnce * (b + static_cast<std::uint32_t>(std::countr_zero(below)));
      addSixteen(&level_->voxels[first], vectors, first, static_cast<int>(run.last - first), q,
                 sum);
    }
  }
  for (int k = 0; k < kTerms; ++k) std::memcpy(smoothSum_[k], &sum[k], sizeof *sum);
}

}  // namespace cloudcontact
