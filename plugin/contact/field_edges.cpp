// The second step of the field: edges and corners. A window across an edge sees a blunt surface
// (30 deg at half a voxel from a right angle). Where a block's quadric does not explain its
// coverage, the flat or gently curved faces found beside it are continued into the block, and the
// intersection (a convex edge) or union (a concave one) of two or three of them that reproduces the
// coverage best is kept, if it does so well enough. Where a face is too narrow to be seen on its
// own (the crest of a thin thread), the plane midway between two others is tried, put where the
// mass wants it.
#include "../geometry/parallel.h"
#include "field_builder.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cloudcontact {

namespace {

// Residuals of coverage, see kernels/surface_fit.h: smooth surfaces leave 0.001, at most 0.003 at a
// radius of 10 voxels; an edge of 20 deg leaves 0.006.
constexpr float kSmoothResidual = 0.004f;
// Blocks that the quadric explains this well keep it: shallow edges, small radii.
constexpr float kEnough = 0.004f;
// An edge must explain the block this well, and better than the quadric by this factor.
constexpr float kEdgeResidual = 0.03f;
constexpr float kEdgeGain = 0.75f;
constexpr int kReach = 3;             // faces are sought this far from the block's middle
constexpr float kFlat = 0.012f;       // curvatures below this are noise and are not continued
constexpr float kSameNormal = 0.97f;  // cosine: faces within 14 deg that also meet are one face
constexpr float kSameOffset = 0.25f;
constexpr int kMaxFaces = 6;
constexpr int kSub = 4;  // sub-samples along a voxel's edge
constexpr int kPerVoxel = kSub * kSub * kSub;
constexpr int kPoints = CC_WINDOW_VOXELS * kPerVoxel;
constexpr float kGoodResidual = 0.008f;  // of two faces: no third is sought
constexpr std::size_t kCrestPairs = 3;
constexpr float kUnseen = 0.012f;  // above it a face that no neighbour shows is sought
constexpr int kMassRounds = 6, kFreeRounds = 5;

// A face continued to the block: n.x < s about the block's middle.
struct Face {
  Eigen::Vector3f n = Eigen::Vector3f::Zero();
  float s = 0;
  float weight = 0;
  Eigen::Matrix3f curvature = Eigen::Matrix3f::Zero();  // n.x + x.curvature.x / 2 < s
};

// The neighbour's surface about the block's middle, which lies at `r` from the neighbour's own.
Face continued(const CcSurface& f, const Eigen::Vector3f& r) {
  const Eigen::Map<const Eigen::Vector3f> n(f.n), t1(f.t1), t2(f.t2);
  Face face;
  face.weight = 1.0f / (0.5f + r.squaredNorm());
  const bool flat = std::max({std::abs(f.k11), std::abs(f.k12), std::abs(f.k22)}) < kFlat;
  if (!flat)
    face.curvature = f.k11 * t1 * t1.transpose() + f.k22 * t2 * t2.transpose() +
                     f.k12 * (t1 * t2.transpose() + t2 * t1.transpose());
  const Eigen::Vector3f bent = face.curvature * r, m = n + bent;
  const float length = m.norm();
  face.n = m / length;
  face.s = (f.s - n.dot(r) - 0.5f * r.dot(bent)) / length;
  return face;
}

// The distinct faces near a voxel, the nearest first, each the mean of what its neighbours say.
std::vector<Face> facesNear(const FieldDraft& draft, const SurfaceVoxel& voxel) {
  std::vector<Face> all;
  for (int dz = -kReach; dz <= kReach; ++dz)
    for (int dy = -kReach; dy <= kReach; ++dy)
      for (int dx = -kReach; dx <= kReach; ++dx) {
        const std::int32_t other = draft.index.at(voxel.x + dx, voxel.y + dy, voxel.z + dz);
        if (other < 0) continue;
        const SurfaceVoxel& from = draft.voxels[static_cast<std::size_t>(other)];
        for (std::uint32_t k = 0; k < from.count; ++k) {
          const CcSurface& f = draft.pieces[from.first + k].surface;
          if (from.rule == PieceRule::Smooth && f.residual > kSmoothResidual) continue;
          all.push_back(continued(f, {float(-dx), float(-dy), float(-dz)}));
        }
      }
  std::stable_sort(all.begin(), all.end(),
                   [](const Face& a, const Face& b) { return a.weight > b.weight; });
  std::vector<Face> faces, sums;
  for (const Face& f : all) {
    std::size_t k = 0;
    while (k < faces.size() &&
           !(faces[k].n.dot(f.n) > kSameNormal && std::abs(faces[k].s - f.s) < kSameOffset))
      ++k;
    if (k == faces.size()) {
      if (k == kMaxFaces) continue;
      faces.push_back(f);
      sums.emplace_back();
    }
    sums[k].n += f.weight * f.n;
    sums[k].s += f.weight * f.s;
    sums[k].curvature += f.weight * f.curvature;
    sums[k].weight += f.weight;
  }
  for (Face& f : sums) {
    f.s /= f.weight;
    f.curvature /= f.weight;
    f.n.normalize();
  }
  return sums;
}

// How far each sub-sample lies outside a face, in sub-sample widths along the normal. Stored voxel
// by voxel, so that a voxel's coverage is a sum over a run.
struct FaceField {
  Face face;
  std::array<float, kPoints> outside;
};

// Where the sub-samples lie, in the order of FaceField.
const std::array<std::array<float, 3>, kPoints>& subSamples() {
  static const auto points = [] {
    std::array<std::array<float, 3>, kPoints> p;
    for (int k = 0; k < kPoints; ++k) {
      const int voxel = k / kPerVoxel, sub = k % kPerVoxel;
      const int v[3] = {voxel % 3, voxel / 3 % 3, voxel / 9},
                s[3] = {sub % kSub, sub / kSub % kSub, sub / kSub / kSub};
      for (int i = 0; i < 3; ++i)
        p[static_cast<std::size_t>(k)][static_cast<std::size_t>(i)] =
            float(v[i]) - 1.5f + (float(s[i]) + 0.5f) / kSub;
    }
    return p;
  }();
  return points;
}

void fillField(const Face& f, FaceField& field) {
  field.face = f;
  const float scale = kSub / f.n.lpNorm<1>();
  const Eigen::Vector3f n = f.n * scale;
  const float s = f.s * scale;
  const auto& points = subSamples();
  for (std::size_t k = 0; k < kPoints; ++k)
    field.outside[k] = n.x() * points[k][0] + n.y() * points[k][1] + n.z() * points[k][2] - s;
  if (f.curvature.isZero()) return;
  const Eigen::Matrix3f half = 0.5f * scale * f.curvature;
  for (std::size_t k = 0; k < kPoints; ++k) {
    const float x = points[k][0], y = points[k][1], z = points[k][2];
    field.outside[k] += x * (half(0, 0) * x + 2 * half(0, 1) * y) +
                        y * (half(1, 1) * y + 2 * half(1, 2) * z) +
                        z * (half(2, 2) * z + 2 * half(0, 2) * x);
  }
}

// At most three faces that bound the material together.
struct Combination {
  const FaceField* face[3];
  int count;
  bool concave;
};

// The block's coverage under a combination.
void coverageOf(const Combination& c, float* coverage) {
  const float* f0 = c.face[0]->outside.data();
  const float* f1 = c.face[1]->outside.data();
  const float* f2 = c.face[c.count - 1]->outside.data();
  for (int v = 0; v < CC_WINDOW_VOXELS; ++v) {
    float sum = 0;
    for (int k = v * kPerVoxel; k < (v + 1) * kPerVoxel; ++k) {
      const float out =
          c.concave ? ccMin(f0[k], ccMin(f1[k], f2[k])) : ccMax(f0[k], ccMax(f1[k], f2[k]));
      sum += ccMin(ccMax(0.5f - out, 0.0f), 1.0f);
    }
    coverage[v] = sum * (1.0f / kPerVoxel);
  }
}

float blockResidual(const float* wanted, const float* found) {
  float square = 0, weight = 0;
  for (int k = 0; k < CC_WINDOW_VOXELS; ++k) {
    const float r = wanted[k] - found[k];
    const bool silent = (found[k] <= 0.0f || found[k] >= 1.0f) && std::abs(r) < 2e-3f;
    if (silent) continue;
    const int dx = k % 3 - 1, dy = k / 3 % 3 - 1, dz = k / 9 - 1;
    const float q = 1.0f - float(dx * dx + dy * dy + dz * dz) / CC_WINDOW_RADIUS2;
    square += q * q * r * r;
    weight += q * q;
  }
  return weight > 0 ? std::sqrt(square / weight) : 1.0f;
}

// What explains a block: faces that intersect, or unite where `concave`.
struct Hypothesis {
  Face faces[3];
  int count = 0;
  bool concave = false;
  float residual = 1.0f;
};

// Tries combinations of faces on one block and keeps the best.
class EdgeSearch {
 public:
  // `mean` is the normal of the block's quadric.
  void run(const float* wanted, const std::vector<Face>& faces, const Eigen::Vector3f& mean) {
    wanted_ = wanted;
    best = {};
    count_ = 0;
    for (const Face& f : faces) {
      // A face that passes the block by says nothing of it.
      if (std::abs(f.s) > 1.5f * f.n.lpNorm<1>()) continue;
      fillField(f, fields_[static_cast<std::size_t>(count_++)]);
    }
    pairs();
    if (best.residual > kGoodResidual) triples();
    if (best.residual > kUnseen) unseen(mean);
  }

  Hypothesis best;

 private:
  struct Pair {
    float residual;
    int i, j;
    bool concave;
  };

  float attempt(const Combination& c) {
    float found[CC_WINDOW_VOXELS];
    coverageOf(c, found);
    const float residual = blockResidual(wanted_, found);
    // A further plane must earn its place.
    if (residual < (c.count > best.count ? 0.8f : 1.0f) * best.residual) {
      best.concave = c.concave;
      best.count = c.count;
      best.residual = residual;
      for (int k = 0; k < c.count; ++k) best.faces[k] = c.face[k]->face;
    }
    return residual;
  }

  const FaceField& field(int i) const { return fields_[static_cast<std::size_t>(i)]; }

  void pairs() {
    tried_.clear();
    for (bool concave : {false, true})
      for (int i = 0; i < count_; ++i)
        for (int j = i + 1; j < count_; ++j)
          tried_.push_back({attempt({{&field(i), &field(j), nullptr}, 2, concave}), i, j, concave});
    std::stable_sort(tried_.begin(), tried_.end(),
                     [](const Pair& a, const Pair& b) { return a.residual < b.residual; });
  }

  void triples() {
    for (bool concave : {false, true})
      for (int i = 0; i < count_; ++i)
        for (int j = i + 1; j < count_; ++j)
          for (int k = j + 1; k < count_; ++k)
            attempt({{&field(i), &field(j), &field(k)}, 3, concave});
  }

  // A face too narrow to be seen on its own: one or two known faces and a plane that is sought. Its
  // normal starts midway between two known ones (a thread's crest), or mirrors one about the
  // block's mean normal; its place is where the block's mass wants it; then Gauss-Newton on the
  // coverage.
  void unseen(const Eigen::Vector3f& mean) {
    Guess best_guess;
    for (std::size_t p = 0; p < tried_.size() && p < kCrestPairs; ++p)
      guess({{&field(tried_[p].i), &field(tried_[p].j), &free_}, 3, tried_[p].concave},
            field(tried_[p].i).face.n + field(tried_[p].j).face.n, best_guess);
    for (int i = 0; i < count_; ++i)
      for (bool concave : {false, true})
        guess({{&field(i), &free_, nullptr}, 2, concave},
              2 * mean.dot(field(i).face.n) * mean - field(i).face.n, best_guess);
    if (best_guess.residual >= 1.0f) return;
    fillField(best_guess.plane, free_);
    for (int round = 0; round < kFreeRounds; ++round) {
      attempt(best_guess.faces);
      if (!improve(best_guess.faces)) break;
    }
    attempt(best_guess.faces);
  }

  struct Guess {
    Combination faces{};
    Face plane;
    float residual = 1.0f;
  };

  void guess(const Combination& c, const Eigen::Vector3f& normal, Guess& best_guess) {
    if (normal.norm() < 0.2f) return;
    for (int k = 0; k + 1 < c.count; ++k)
      if (c.face[k]->face.n.dot(normal.normalized()) > kSameNormal) return;
    float mass = 0;
    for (int k = 0; k < CC_WINDOW_VOXELS; ++k) mass += wanted_[k];
    Face plane;
    plane.n = normal.normalized();
    float low = -2, high = 2, found[CC_WINDOW_VOXELS];
    for (int round = 0; round < kMassRounds; ++round) {
      plane.s = 0.5f * (low + high);
      fillField(plane, free_);
      coverageOf(c, found);
      float sum = 0;
      for (float v : found) sum += v;
      (sum < mass ? low : high) = plane.s;
    }
    const float residual = blockResidual(wanted_, found);
    if (residual < best_guess.residual) best_guess = {c, plane, residual};
  }

  // One Gauss-Newton round for the free plane, the last of the combination.
  bool improve(const Combination& c) {
    const Face& plane = free_.face;
    const Eigen::Vector3f t1 = plane.n.unitOrthogonal(), t2 = plane.n.cross(t1);
    const float scale = kSub / plane.n.lpNorm<1>() / kPerVoxel;
    Eigen::Matrix3f normal = 1e-4f * Eigen::Matrix3f::Identity();
    Eigen::Vector3f right = Eigen::Vector3f::Zero();
    const auto& points = subSamples();
    for (int v = 0; v < CC_WINDOW_VOXELS; ++v) {
      Eigen::Vector3f gradient = Eigen::Vector3f::Zero();
      float sum = 0;
      for (std::size_t k = static_cast<std::size_t>(v * kPerVoxel), end = k + kPerVoxel; k < end;
           ++k) {
        float out = free_.outside[k];
        bool active = true;
        for (int i = 0; i + 1 < c.count; ++i) {
          const float other = c.face[i]->outside[k];
          if (c.concave ? other < out : other > out) {
            out = other;
            active = false;
          }
        }
        sum += std::clamp(0.5f - out, 0.0f, 1.0f);
        if (!active || std::abs(out) > 0.5f) continue;
        const Eigen::Map<const Eigen::Vector3f> x(points[k].data());
        gradient += scale * Eigen::Vector3f(1, -t1.dot(x), -t2.dot(x));
      }
      normal += gradient * gradient.transpose();
      right += gradient * (wanted_[v] - sum * (1.0f / kPerVoxel));
    }
    const Eigen::Vector3f step = normal.ldlt().solve(right);
    if (!step.allFinite()) return false;
    const float shorten = 0.4f / std::max(0.4f, step.cwiseAbs().maxCoeff());
    Face next;
    next.n = plane.n + shorten * (step.y() * t1 + step.z() * t2);
    next.s = (plane.s + shorten * step.x()) / next.n.norm();
    next.n.normalize();
    fillField(next, free_);
    return step.cwiseAbs().maxCoeff() > 1e-3f;
  }

  const float* wanted_ = nullptr;
  int count_ = 0;
  std::array<FaceField, kMaxFaces> fields_;
  FaceField free_;  // of the plane that is sought
  std::vector<Pair> tried_;
};

CcSurface planeSurface(const Face& f, float residual) {
  CcSurface s{};
  for (int i = 0; i < 3; ++i) s.n[i] = f.n[i];
  ccTangents(s.n, s.t1, s.t2);
  s.s = f.s;
  const Eigen::Map<const Eigen::Vector3f> t1(s.t1), t2(s.t2);
  s.k11 = t1.dot(f.curvature * t1);
  s.k12 = t1.dot(f.curvature * t2);
  s.k22 = t2.dot(f.curvature * t2);
  s.residual = residual;
  s.weight = 1;
  return s;
}

// One pass over the voxels that are still unexplained.
void resolvePass(FieldDraft& draft) {
  std::vector<Hypothesis> found(draft.voxels.size());
  const int threads = threadCount(draft.settings.threads);
  std::vector<EdgeSearch> searches(static_cast<std::size_t>(threads));
  parallelFor((draft.voxels.size() + 255) / 256, threads, [&](std::size_t chunk, int worker) {
    EdgeSearch& search = searches[static_cast<std::size_t>(worker)];
    const std::size_t end = std::min(draft.voxels.size(), (chunk + 1) * 256);
    for (std::size_t i = chunk * 256; i < end; ++i) {
      const SurfaceVoxel& v = draft.voxels[i];
      const CcSurface& own = draft.pieces[v.first].surface;
      if (v.rule != PieceRule::Smooth || own.residual <= kEnough) continue;
      float block[CC_WINDOW_VOXELS];
      gatherBlock(draft.cloud, v.x, v.y, v.z, block);
      search.run(block, facesNear(draft, v), Eigen::Map<const Eigen::Vector3f>(own.n));
      if (search.best.residual < kEdgeResidual && search.best.residual < kEdgeGain * own.residual)
        found[i] = search.best;
    }
  });
  for (std::size_t i = 0; i < draft.voxels.size(); ++i) {
    const Hypothesis& h = found[i];
    if (h.count == 0) continue;
    SurfaceVoxel& v = draft.voxels[i];
    v.rule = h.concave ? PieceRule::Concave : PieceRule::Convex;
    v.first = static_cast<std::uint32_t>(draft.pieces.size());
    v.count = static_cast<std::uint32_t>(h.count);
    for (int k = 0; k < h.count; ++k)
      draft.pieces.push_back({planeSurface(h.faces[k], h.residual), {0, 0, 0}, 0});
  }
}

}  // namespace

// Twice: faces that the first pass found beside an edge serve their neighbours in the second.
void resolveEdges(FieldDraft& draft) {
  resolvePass(draft);
  resolvePass(draft);
  for (SurfaceVoxel& v : draft.voxels)
    v.doubtful =
        v.rule == PieceRule::Smooth && draft.pieces[v.first].surface.residual > kEdgeResidual;
}

}  // namespace cloudcontact
