// Divides voxels along the quadric fitted to their neighborhood: see local_surface.h.
#include "voxels/local_surface.h"

#include <algorithm>
#include <cmath>

#include "base/grid_index.h"
#include "base/parallel.h"
#include "kernels/contact/surface_fit.h"

namespace cloudcontact {

namespace {

using Eigen::Vector3f;
using Eigen::Vector3i;

// Above this residual of coverage [rms] an edge runs through the block, and no quadric fits it
// (kernels/contact/surface_fit.h).
constexpr float kEdge = 0.3f;

CcSurface fitAt(const Cloud& cloud, const Vector3i& voxel) {
  float block[CC_WINDOW_VOXELS];
  for (int k = 0; k < CC_WINDOW_VOXELS; ++k)
    block[k] = static_cast<float>(cloud.coverage(voxel[0] + k % 3 - 1, voxel[1] + k / 3 % 3 - 1,
                                                 voxel[2] + k / 9 - 1)) /
               255;
  return ccFitSurface(block, 0);
}

// The surface seen from `at` [voxels from the voxel's center]: its outward direction, not of unit
// length, and the height of `at`.
struct Look {
  Vector3f direction;
  float height;  // of `at` above the surface, times the direction's length
};
Look lookFrom(const CcSurface& f, const Vector3f& at) {
  const Eigen::Map<const Vector3f> n(f.n), t1(f.t1), t2(f.t2);
  const float u = t1.dot(at), v = t2.dot(at);
  const float ku = f.k11 * u + f.k12 * v, kv = f.k12 * u + f.k22 * v;
  return {n + ku * t1 + kv * t2, n.dot(at) - f.s + 0.5f * (ku * u + kv * v)};
}

// Cuts a cube of edge `edge` around `at` by the surface, shifted outward by `shift`.
CcCut cutCube(const CcSurface& f, const Vector3f& at, float edge, float shift) {
  const Look look = lookFrom(f, at);
  const float length = look.direction.norm();
  const Vector3f n = look.direction / length;
  const float sag = (f.k11 + f.k22) * edge * edge / 24;  // the quadric's mean over the cube
  CcCut cut = ccCutCube(n[0], n[1], n[2], (shift - look.height - sag) / (length * edge));
  cut.area /= length * edge;
  return cut;
}

Vector3f cubeCenter(int k, int n) {
  return Vector3f(static_cast<float>(k % n), static_cast<float>(k / n % n),
                  static_cast<float>(k / (n * n))) /
             static_cast<float>(n) +
         Vector3f::Constant(0.5f / static_cast<float>(n) - 0.5f);
}

bool crossed(const Cloud& cloud, const Vector3i& at, int own) {
  if (own > 0 && own < 255) return true;
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {-1, 1}) {
      const Vector3i other = at + side * Vector3i::Unit(axis);
      if (cloud.coverage(other[0], other[1], other[2]) == 255 - own) return true;
    }
  return false;
}

void placesInVoxel(const Cloud& cloud, const Vector3i& voxel, int n,
                   std::vector<SurfacePlace>& places) {
  const CcSurface f = fitAt(cloud, voxel);
  if (f.weight == 0 || f.residual > kEdge) return;
  const float half = 0.5f / static_cast<float>(n) + 1e-3f;
  for (int k = 0; k < n * n * n; ++k) {
    const Vector3f middle = cubeCenter(k, n);
    Vector3f foot = middle;
    for (int step = 0; step < 2; ++step) {  // the second corrects for curvature: 1e-3
      const Look look = lookFrom(f, foot);
      foot -= look.height / look.direction.squaredNorm() * look.direction;
    }
    if ((foot - middle).cwiseAbs().maxCoeff() > half) continue;
    const Vec3 center = cloud.center(voxel[0], voxel[1], voxel[2]);
    places.push_back({center + cloud.voxelSize() * foot.cast<double>(),
                      lookFrom(f, foot).direction.cast<double>().normalized(),
                      cloud.material(voxel[0], voxel[1], voxel[2])});
  }
}

}  // namespace

void divideVoxel(const Cloud& cloud, const Vector3i& voxel, int n, std::vector<float>& shares) {
  const int own = cloud.coverage(voxel[0], voxel[1], voxel[2]);
  const float whole = static_cast<float>(own) / 255;
  shares.assign(static_cast<std::size_t>(n * n * n), whole);
  if (own == 0 || own == 255 || n == 1) return;
  const CcSurface f = fitAt(cloud, voxel);
  if (f.weight == 0) return;
  const float edge = 1 / static_cast<float>(n);
  // The mean share increases with the shift: Newton's method, safeguarded by bisection.
  float low = -2, high = 2, shift = 0;
  for (int round = 0; round < 30; ++round) {
    float sum = 0, slope = 0;
    for (std::size_t k = 0; k < shares.size(); ++k) {
      const CcCut cut = cutCube(f, cubeCenter(static_cast<int>(k), n), edge, shift);
      shares[k] = cut.volume;
      sum += cut.volume, slope += cut.area;
    }
    const float off = sum / static_cast<float>(shares.size()) - whole;
    if (std::abs(off) < 1e-5f) return;
    (off > 0 ? high : low) = shift;
    const float newton = shift - off * static_cast<float>(shares.size()) / std::max(slope, 1e-6f);
    shift = newton > low && newton < high ? newton : 0.5f * (low + high);
  }
}

std::vector<SurfacePlace> surfacePlaces(const Cloud& cloud, int n, int threads) {
  std::vector<SurfacePlace> places;
  if (cloud.empty()) return places;
  const Vector3i bricks = cloud.bricks();
  std::vector<std::vector<SurfacePlace>> found(cloud.voxels().table.size());
  parallelFor(found.size(), threads, [&](std::size_t entry, int) {
    if (cloud.voxels().table[entry] == kEmptyBrick)
      return;  // the surface lies in or beside voxels with material
    const Vector3i corner = kBrickEdge * gridCell(entry, bricks);
    for (int v = 0; v < kBrickVoxels; ++v) {
      const Vector3i at = corner + cellOffset(v);
      const int own = cloud.coverage(at[0], at[1], at[2]);
      if (own > 0 && crossed(cloud, at, own)) placesInVoxel(cloud, at, n, found[entry]);
    }
  });
  for (const auto& list : found) places.insert(places.end(), list.begin(), list.end());
  return places;
}

}  // namespace cloudcontact
