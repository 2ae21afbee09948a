// Brick by brick: what the vectors of a brick's samples read is gathered once.
#include "field/sample_vectors.h"

#include "base/parallel.h"
#include "base/simd.h"
#include "kernels/base/plane_cell.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <tuple>
#include <utility>

namespace cloudcontact {

namespace {

using V3 = Eigen::Vector3f;
using V3i = Eigen::Vector3i;

constexpr float kRadius = 3.5f;                   // of C [voxels]
constexpr float kLength = 35.0f / 128 * kRadius;  // of a flat face's vector
constexpr float kAgree = 0.95f;  // cosine between a face in C and the sample's own, continued
// Largest residual of a fit whose curvature goes on beyond its block.
constexpr float kSound = 0.004f;
// The same of a surface in C. Where fits explain their blocks worse, an edge is near that they
// blur: of a nut's samples that differ by over 3 deg from their fit, nine of ten were wrong with
// it.
constexpr float kClear = 0.01f;
// A difference of coverage below the rounding to 1/255 says nothing.
constexpr float kNoise = 0.001f;

constexpr int kReach = 4;                     // from the sample's voxel to those of the ball
constexpr int kRim = kReach + 1;              // and one step on to a surface beside them
constexpr int kEdge = kBrickEdge + 2 * kRim;  // of what a brick's samples read
constexpr int kVoxels = kEdge * kEdge * kEdge;
constexpr int kMost = 256;  // voxels whose centers lie in the ball; about 180

constexpr double kVectorCost = 2.5, kBlockCost = 8;  // of a sample and of a brick [us]

// What lies in and around a brick.
class Block {
 public:
  void fill(const FieldDraft& draft, const V3i& brick) {
    low_ = kBrickEdge * brick - V3i::Constant(kRim);
    std::memset(count_, 0, sizeof count_);
    for (int k = 0; k < 27; ++k) fillFrom(draft, brick + V3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
  }
  const V3i& low() const { return low_; }
  static int index(const V3i& at) { return at.x() + kEdge * (at.y() + kEdge * at.z()); }
  float coverage(int i) const { return coverage_[i]; }

  // Whether the surface in or beside a voxel (from low()) faces along `n`. Beside: a step along it,
  // toward the surface.
  bool faces(const V3i& at, const V3& n) const {
    const int i = index(at);
    if (count_[i] > 0) return allFace(i, n);
    const V3 step = coverage_[i] > 0.5f ? n : V3(-n);
    const V3i next = (at.cast<float>() + V3::Constant(0.5f) + step).array().floor().cast<int>();
    return allFace(index(next), n);
  }

 private:
  bool allFace(int i, const V3& n) const {
    for (int k = 0; k < count_[i]; ++k) {
      const CcSurface& f = pieces_[i][k].surface;
      if (f.residual > kClear || !(Eigen::Map<const V3>(f.n).dot(n) >= kAgree)) return false;
    }
    return count_[i] > 0;
  }

  void fillFrom(const FieldDraft& draft, const V3i& brick) {
    const V3i from = (kBrickEdge * brick).cwiseMax(low_),
              to = (kBrickEdge * (brick + V3i::Ones())).cwiseMin(low_ + V3i::Constant(kEdge));
    const Eigen::Vector3i size = draft.cloud.bricks();
    const bool inside = insideGrid(brick, size);
    const std::int32_t stored =
        inside ? draft.cloud.voxels().table[gridIndex(brick, size)] : kEmptyBrick;
    for (int z = from.z(); z < to.z(); ++z)
      for (int y = from.y(); y < to.y(); ++y) {
        float* const row = coverage_ + index(V3i(from.x(), y, z) - low_);
        const int width = to.x() - from.x();
        if (stored < 0) {
          std::fill_n(row, width, stored == kSolidBrick ? 1.0f : 0.0f);
          continue;
        }
        const std::uint8_t* const voxels =
            draft.cloud.voxels().coverage[static_cast<std::size_t>(stored)].data() +
            cellIndex(from.x(), y, z);
        for (int x = 0; x < width; ++x) row[x] = float(voxels[x]) * (1.0f / 255);
      }
    const SurfaceBrick* const surface = inside ? draft.brickAt(brick) : nullptr;
    if (!surface) return;
    for (const SurfaceVoxel& v : surface->voxels) {
      const V3i at = kBrickEdge * brick + cellOffset(v.cell);
      if ((at.array() < from.array()).any() || (at.array() >= to.array()).any()) continue;
      const VoxelState state = surface->stateAt(v.last);
      const int i = index(at - low_);
      pieces_[i] = state.pieces;
      count_[i] = static_cast<std::uint8_t>(state.count());
    }
  }

  V3i low_ = V3i::Zero();
  float coverage_[kVoxels];
  const SurfacePiece* pieces_[kVoxels];
  std::uint8_t count_[kVoxels];
};

// The voxels of a ball, side by side.
struct Ball {
  int count = 0;
  V3i at[kMost];
  float x[kMost], y[kMost], z[kMost];  // from the sample to the center
  float weight[kMost], measured[kMost], model[kMost];
};

// The sample's own face about the sample: n, and how it bends along t1 and t2 (CcSurface).
struct Face {
  V3 n, t1 = V3::Zero(), t2 = V3::Zero();
  float k11 = 0, k12 = 0, k22 = 0;
};

void gather(const Block& block, const V3& sample, Ball& ball) {
  const V3i middle = sample.array().floor().cast<int>();
  ball.count = 0;
  for (int z = -kReach; z <= kReach; ++z)
    for (int y = -kReach; y <= kReach; ++y) {
      const float ry = float(middle.y() + y) + 0.5f - sample.y(),
                  rz = float(middle.z() + z) + 0.5f - sample.z();
      const float square = ry * ry + rz * rz;
      if (square >= kRadius * kRadius) continue;
      for (int x = -kReach; x <= kReach; ++x) {
        const float rx = float(middle.x() + x) + 0.5f - sample.x();
        const float left = 1 - (rx * rx + square) * (1 / (kRadius * kRadius));
        if (left <= 0) continue;
        const int k = ball.count++;
        ball.at[k] = middle + V3i(x, y, z);
        ball.x[k] = rx, ball.y[k] = ry, ball.z[k] = rz;
        ball.weight[k] = left * left;
        ball.measured[k] = block.coverage(Block::index(ball.at[k]));
      }
    }
}

// The part of each voxel below the face. The last term of the offset: as in ccPredict().
CC_LANES [[gnu::flatten]] void modelFace(const Face& face, Ball& ball) {
  const float nx = face.n.x(), ny = face.n.y(), nz = face.n.z();
  const float ux = face.t1.x(), uy = face.t1.y(), uz = face.t1.z();
  const float vx = face.t2.x(), vy = face.t2.y(), vz = face.t2.z();
  const float k11 = 0.5f * face.k11, k12 = face.k12, k22 = 0.5f * face.k22;
  const float mean = (k11 + k22) * (1.0f / 12);
  const int count = ball.count;
  CC_INDEPENDENT
  for (int k = 0; k < count; ++k) {
    const float x = ball.x[k], y = ball.y[k], z = ball.z[k];
    const float u = ux * x + uy * y + uz * z, v = vx * x + vy * y + vz * z;
    const float bend = k11 * u * u + k12 * u * v + k22 * v * v + mean;
    ball.model[k] = ccCutCube(nx, ny, nz, -(nx * x + ny * y + nz * z) - bend).volume;
  }
}

// The face's normal at r.
V3 normalAt(const Face& face, const V3& r) {
  const float u = face.t1.dot(r), v = face.t2.dot(r);
  return (face.n + (face.k11 * u + face.k12 * v) * face.t1 +
          (face.k12 * u + face.k22 * v) * face.t2)
      .normalized();
}

// The direction of the base vector of a sample, `at` from the block's corner.
V3 baseVector(const Block& block, const V3& at, const Face& face, Ball& ball) {
  gather(block, at, ball);
  modelFace(face, ball);
  const V3& n = face.n;
  float mass = 0;
  V3 moment = V3::Zero();
  for (int k = 0; k < ball.count; ++k) {
    mass += ball.weight[k] * ball.model[k];
    const float more = ball.model[k] - ball.measured[k];
    if (std::abs(more) < kNoise) continue;
    const V3 r(ball.x[k], ball.y[k], ball.z[k]), mirrored = 2 * n.dot(r) * n - r;
    if (!block.faces(ball.at[k], normalAt(face, r))) continue;
    const V3i beyond = (at + mirrored).array().floor().cast<int>();
    if (!block.faces(beyond, normalAt(face, mirrored))) continue;
    moment += ball.weight[k] * more * r;
  }
  return mass > 0 ? V3(kLength * n + moment / mass).normalized() : n;
}

// A sample's face: as curved as the fit of its voxel, where that holds no edge.
Face faceOf(const FieldDraft& draft, const CutSample& from) {
  Face face{Eigen::Map<const V3>(from.sample.normal)};
  const VoxelState state =
      draft.brick(static_cast<std::size_t>(from.origin.brick))->state(from.origin.cell);
  const CcSurface& f = state.pieces[0].surface;
  if (state.count() > 1 || f.residual > kSound) return face;
  face.t1 = Eigen::Map<const V3>(f.t1);
  face.t2 = Eigen::Map<const V3>(f.t2);
  face.k11 = f.k11, face.k12 = f.k12, face.k22 = f.k22;
  return face;
}

V3i brickOf(const SurfaceSample& s) {
  return (Eigen::Map<const V3>(s.position) / float(kBrickEdge)).array().floor().cast<int>();
}

// The samples of a brick, from the same corner as the brick's.
struct Run {
  V3i brick;
  std::size_t begin, end;
};

// The samples' places in `samples` by brick, and the runs of each.
std::vector<Run> runsOf(const std::vector<CutSample>& samples, std::vector<std::uint32_t>& order) {
  order.resize(samples.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::uint32_t>(i);
  std::vector<V3i> bricks(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) bricks[i] = brickOf(samples[i].sample);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const V3i &x = bricks[a], &y = bricks[b];
    return std::tuple(x.z(), x.y(), x.x()) < std::tuple(y.z(), y.y(), y.x());
  });
  std::vector<Run> runs;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || bricks[order[i]] != runs.back().brick) runs.push_back({bricks[order[i]], i, i});
    runs.back().end = i + 1;
  }
  return runs;
}

}  // namespace

void giveBaseVectors(const FieldDraft& draft, std::vector<CutSample>& samples) {
  std::vector<std::uint32_t> order;
  const std::vector<Run> runs = runsOf(samples, order);
  struct Memory {
    Block block;
    Ball ball;
  };
  std::vector<std::unique_ptr<Memory>> memory(static_cast<std::size_t>(threadCount(draft.threads)));
  const std::size_t atOnce = draft.partsAtOnce(8, runs.size());
  for (std::size_t first = 0; first < runs.size(); first += atOnce) {
    const std::size_t count = std::min(atOnce, runs.size() - first);
    parallelFor(count, draft.threads, [&](std::size_t i, int thread) {
      std::unique_ptr<Memory>& own = memory[static_cast<std::size_t>(thread)];
      if (!own) own = std::make_unique<Memory>();
      const Run& run = runs[first + i];
      own->block.fill(draft, run.brick);
      const V3 low = own->block.low().cast<float>();
      for (std::size_t k = run.begin; k < run.end; ++k) {
        CutSample& sample = samples[order[k]];
        const V3 at = Eigen::Map<const V3>(sample.sample.position) - low;
        Eigen::Map<V3>(sample.sample.normal) =
            baseVector(own->block, at, faceOf(draft, sample), own->ball);
      }
    });
    const std::size_t made = runs[first + count - 1].end - runs[first].begin;
    draft.spend(kBlockCost * static_cast<double>(count) + kVectorCost * static_cast<double>(made));
  }
}

}  // namespace cloudcontact
