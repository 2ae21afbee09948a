// The third step of the field: samples. Each piece of surface inside a voxel becomes a quadrature
// point at its centroid with its area, so that sums over samples integrate linear functions over
// flat faces exactly. A piece that lies in the face between two voxels must be counted once: the
// plane is cut at four offsets within an eighth of a voxel about its place and the areas
// averaged, so that each voxel has half of it however the fits' noise falls.
#include "field_builder.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

using V3 = Eigen::Vector3f;

constexpr int kJitters = 4;
constexpr float kJitter[kJitters] = {-0.09375f, -0.03125f, 0.03125f, 0.09375f};
constexpr float kLeastArea =
    1e-3f;                     // [voxel^2] smaller pieces are dropped: 0.1 % of a voxel's face
constexpr int kEdgeCells = 2;  // cells along a voxel that an edge runs through

// A convex polygon of at most 16 corners.
struct Polygon {
  V3 corner[16];
  int count = 0;

  // Keeps what lies below the plane n.x < s.
  void clip(const V3& n, float s) {
    V3 kept[16];
    int keep = 0;
    for (int i = 0; i < count; ++i) {
      const V3 &a = corner[i], &b = corner[(i + 1) % count];
      const float da = n.dot(a) - s, db = n.dot(b) - s;
      if (da <= 0 && keep < 16) kept[keep++] = a;
      if ((da < 0 && db > 0) || (da > 0 && db < 0))
        if (keep < 16) kept[keep++] = a + (b - a) * (da / (da - db));
    }
    std::copy(kept, kept + keep, corner);
    count = keep;
  }

  // Adds area, and area times centroid.
  void moments(float& area, V3& first) const {
    for (int i = 2; i < count; ++i) {
      const float a = 0.5f * (corner[i - 1] - corner[0]).cross(corner[i] - corner[0]).norm();
      area += a;
      first += a * (corner[0] + corner[i - 1] + corner[i]) / 3;
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

// The part of piece `own` inside the box, bounded by the voxel's other pieces: area and centroid.
float cutPiece(const FieldDraft& draft, const SurfaceVoxel& v, std::uint32_t own, const V3& low,
               float edge, V3& centroid) {
  const CcSurface& f = draft.pieces[v.first + own].surface;
  const Eigen::Map<const V3> n(f.n);
  float area = 0;
  V3 first = V3::Zero();
  for (float jitter : kJitter) {
    Polygon p = squareOn(f, jitter);
    for (int axis = 0; axis < 3; ++axis) {
      p.clip(V3::Unit(axis), low[axis] + edge);
      p.clip(-V3::Unit(axis), -low[axis]);
    }
    for (std::uint32_t k = 0; k < v.count; ++k) {
      if (k == own) continue;
      const CcSurface& other = draft.pieces[v.first + k].surface;
      const Eigen::Map<const V3> m(other.n);
      const float sign = v.rule == PieceRule::Concave ? -1.0f : 1.0f;
      p.clip(sign * m, sign * other.s);
    }
    p.moments(area, first);
  }
  if (area < kJitters * kLeastArea * edge * edge) return 0;
  centroid = first / area;
  centroid += n * (f.s - n.dot(centroid));
  return area / kJitters;
}

// Where the curved surface runs over the piece: the mean over its own width, and the normal there.
SurfaceSample onSurface(const CcSurface& f, const V3& flat, float area, const V3& middle) {
  const Eigen::Map<const V3> n(f.n), t1(f.t1), t2(f.t2);
  const float u = t1.dot(flat), v = t2.dot(flat), spread = area / 12;
  const float ku = f.k11 * u + f.k12 * v, kv = f.k12 * u + f.k22 * v;
  const float drop = 0.5f * (ku * u + kv * v + spread * (f.k11 + f.k22));
  const V3 at = middle + flat - drop * n, normal = (n + ku * t1 + kv * t2).normalized();
  SurfaceSample s;
  for (int i = 0; i < 3; ++i) {
    s.position[i] = at[i];
    s.normal[i] = normal[i];
  }
  s.area = area;
  return s;
}

void cutVoxel(FieldDraft& draft, const SurfaceVoxel& v, std::vector<SurfaceSample>& samples) {
  const int cells = v.count > 1 ? kEdgeCells : 1;
  const float edge = 1.0f / static_cast<float>(cells);
  const V3 middle(float(v.x) + 0.5f, float(v.y) + 0.5f, float(v.z) + 0.5f);
  for (std::uint32_t own = 0; own < v.count; ++own) {
    SurfacePiece& piece = draft.pieces[v.first + own];
    V3 sum = V3::Zero();
    for (int c = 0; c < cells * cells * cells; ++c) {
      const V3 low =
          V3(float(c % cells), float(c / cells % cells), float(c / cells / cells)) * edge -
          V3::Constant(0.5f);
      V3 centroid;
      const float area = cutPiece(draft, v, own, low, edge, centroid);
      if (area == 0) continue;
      samples.push_back(onSurface(piece.surface, centroid, area, middle));
      piece.area += area;
      sum += area * (centroid + middle);
    }
    // A plane without a piece of its own still stands somewhere: at its point nearest the voxel.
    const Eigen::Map<const V3> n(piece.surface.n);
    const V3 at = piece.area > 0 ? V3(sum / piece.area) : V3(middle + n * piece.surface.s);
    for (int i = 0; i < 3; ++i) piece.centroid[i] = at[i];
  }
}

}  // namespace

std::vector<SurfaceSample> cutSamples(FieldDraft& draft) {
  std::vector<SurfaceSample> samples;
  samples.reserve(draft.voxels.size());
  for (const SurfaceVoxel& v : draft.voxels) cutVoxel(draft, v, samples);
  return samples;
}

}  // namespace cloudcontact
