// A piece that lies in the face between two voxels must count once: its plane is cut at four
// offsets within an eighth of a voxel of its place and the areas are averaged, so that each voxel
// has half of it whatever the noise of the fits.
#include "field/piece_cut.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

using V3 = Eigen::Vector3f;

constexpr int kJitters = 4;
constexpr float kJitter[kJitters] = {-kMostJitter, -0.03125f, 0.03125f, kMostJitter};
constexpr float kLeastArea = 1e-3f;  // [voxel^2] smaller pieces are dropped

// A convex polygon of at most 16 corners.
struct Polygon {
  V3 corner[16];
  int count = 0;

  // Keeps the part with n.x < s.
  void clip(const V3& n, float s) {
    clipWhere([&](const V3& x) { return n.dot(x) - s; });
  }
  // Keeps the part between low and high along an axis.
  void clip(int axis, float low, float high) {
    clipWhere([&](const V3& x) { return x[axis] - high; });
    clipWhere([&](const V3& x) { return low - x[axis]; });
  }

  // Keeps the part where beyond() is negative.
  template <typename Beyond>
  void clipWhere(Beyond&& beyond) {
    float far[16], most = -1;
    for (int i = 0; i < count; ++i) most = std::max(most, far[i] = beyond(corner[i]));
    if (most <= 0) return;
    V3 kept[16];
    int keep = 0;
    for (int i = 0; i < count; ++i) {
      const int next = i + 1 < count ? i + 1 : 0;
      const V3 &a = corner[i], &b = corner[next];
      const float da = far[i], db = far[next];
      if (da <= 0 && keep < 16) kept[keep++] = a;
      if ((da < 0 && db > 0) || (da > 0 && db < 0))
        if (keep < 16) kept[keep++] = a + (b - a) * (da / (da - db));
    }
    std::copy(kept, kept + keep, corner);
    count = keep;
  }

  // Adds area, area times centroid, and the integral of the squared distance from the line along n.
  void moments(const V3& n, float& area, V3& first, float& second) const {
    for (int i = 2; i < count; ++i) {
      const V3 &p = corner[0], &q = corner[i - 1], &r = corner[i];
      const float a = 0.5f * (q - p).cross(r - p).norm();
      const V3 sum = p + q + r;
      area += a;
      first += a * sum / 3;
      const auto square = [&n](const V3& v) { return v.squaredNorm() - n.dot(v) * n.dot(v); };
      second += a * (square(p) + square(q) + square(r) + square(sum)) / 12;
    }
  }
};

Polygon squareOn(const CcSurface& f, float offset) {
  const Eigen::Map<const V3> n(f.n), t1(f.t1), t2(f.t2);
  const V3 middle = n * (f.s + offset);
  Polygon p;
  p.count = 4;
  p.corner[0] = middle + 2 * t1 + 2 * t2;
  p.corner[1] = middle - 2 * t1 + 2 * t2;
  p.corner[2] = middle - 2 * t1 - 2 * t2;
  p.corner[3] = middle + 2 * t1 - 2 * t2;
  return p;
}

// Distance along piece `own` from a point on it to the nearest edge that bounds it.
float toEdge(const VoxelState& v, int own, const V3& x) {
  const Eigen::Map<const V3> n(v.pieces[own].surface.n);
  float nearest = 1e9f;
  for (int k = 0; k < v.count(); ++k) {
    if (k == own) continue;
    const CcSurface& other = v.pieces[k].surface;
    const Eigen::Map<const V3> m(other.n);
    const float along = (m - n.dot(m) * n).norm();
    if (along > 1e-3f) nearest = std::min(nearest, std::abs(other.s - m.dot(x)) / along);
  }
  return nearest;
}

}  // namespace

CutPart cutPiece(const VoxelState& v, int own, const V3& low, float edge) {
  const CcSurface& f = v.pieces[own].surface;
  const Eigen::Map<const V3> n(f.n);
  const float off = n.dot(low + V3::Constant(0.5f * edge)) - f.s;
  if (std::abs(off) > 0.5f * edge * n.lpNorm<1>() + kMostJitter) return {};
  float area = 0, second = 0, alone = 0, unused = 0;
  V3 first = V3::Zero(), nowhere = V3::Zero();
  for (float jitter : kJitter) {
    Polygon p = squareOn(f, jitter);
    for (int axis = 0; axis < 3; ++axis) p.clip(axis, low[axis], low[axis] + edge);
    if (v.count() > 1) p.moments(n, alone, nowhere, unused);
    for (int k = 0; k < v.count(); ++k) {
      if (k == own) continue;
      const CcSurface& other = v.pieces[k].surface;
      const Eigen::Map<const V3> m(other.n);
      const float sign = v.rule() == PieceRule::Concave ? -1.0f : 1.0f;
      p.clip(sign * m, sign * other.s);
    }
    p.moments(n, area, first, second);
  }
  if (area < kJitters * kLeastArea * edge * edge) return {};
  CutPart part{area / kJitters, first / area, 0, area < 0.999f * alone};
  const float across = n.dot(part.centroid);
  const float spread = second / area - part.centroid.squaredNorm() + across * across;
  part.width = std::sqrt(6 * std::max(spread, 0.0f));
  part.centroid += n * (f.s - n.dot(part.centroid));
  if (part.bounded) part.width = std::min(part.width, 2 * toEdge(v, own, part.centroid));
  return part;
}

SurfaceSample sampleOf(const CcSurface& f, const CutPart& part, const V3& center) {
  const Eigen::Map<const V3> n(f.n), t1(f.t1), t2(f.t2);
  const V3& flat = part.centroid;
  const float u = t1.dot(flat), v = t2.dot(flat), spread = part.width * part.width / 12;
  const float ku = f.k11 * u + f.k12 * v, kv = f.k12 * u + f.k22 * v;
  const float drop = 0.5f * (ku * u + kv * v + spread * (f.k11 + f.k22));
  const V3 at = center + flat - drop * n, normal = (n + ku * t1 + kv * t2).normalized();
  SurfaceSample s;
  for (int i = 0; i < 3; ++i) {
    s.position[i] = at[i];
    s.normal[i] = normal[i];
  }
  s.area = part.area;
  s.width = part.width;
  return s;
}

}  // namespace cloudcontact
