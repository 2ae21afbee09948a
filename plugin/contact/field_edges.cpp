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
#include <cmath>

namespace cloudcontact {

namespace {

// Residuals of coverage, see kernels/surface_fit.h: smooth surfaces leave 0.001, at most 0.003 at a
// radius of 10 voxels; an edge of 20 deg leaves 0.006.
constexpr float kSmoothResidual = 0.004f;
// An edge must explain the block this well, and better than the quadric by this factor.
constexpr float kEdgeResidual = 0.03f;
constexpr float kEdgeGain = 0.6f;
constexpr int kReach = 3;             // faces are sought this far from the block's middle
constexpr float kFlat = 0.012f;       // curvatures below this are noise and are not continued
constexpr float kSameNormal = 0.97f;  // cosine: faces within 14 deg that also meet are one face
constexpr float kSameOffset = 0.25f;
constexpr int kMaxFaces = 6;
constexpr int kSub = 4;  // sub-samples along a voxel's edge
constexpr int kSubs = 3 * kSub;
constexpr int kPoints = kSubs * kSubs * kSubs;

// A face continued to the block: n.x < s about the block's middle.
struct Face {
  Eigen::Vector3f n;
  float s;
  float weight;
};

// The neighbour's surface as a plane at the point nearest to the origin, which lies at `r` from it.
Face continued(const CcSurface& f, const Eigen::Vector3f& r) {
  const Eigen::Map<const Eigen::Vector3f> n(f.n), t1(f.t1), t2(f.t2);
  const bool flat = std::max({std::abs(f.k11), std::abs(f.k12), std::abs(f.k22)}) < kFlat;
  const float u = flat ? 0 : t1.dot(r), v = flat ? 0 : t2.dot(r);
  const float ku = f.k11 * u + f.k12 * v, kv = f.k12 * u + f.k22 * v;
  Eigen::Vector3f m = n + ku * t1 + kv * t2;
  const float phi = n.dot(r) + 0.5f * (ku * u + kv * v) - f.s;
  const float length = m.norm();
  return {m / length, -phi / length, 1.0f / (0.5f + r.squaredNorm())};
}

// The distinct faces near a voxel, the nearest first, each the mean of what its neighbours say.
std::vector<Face> facesNear(const FieldDraft& draft, const SurfaceVoxel& voxel) {
  std::vector<Face> all;
  for (int dz = -kReach; dz <= kReach; ++dz)
    for (int dy = -kReach; dy <= kReach; ++dy)
      for (int dx = -kReach; dx <= kReach; ++dx) {
        const std::int32_t other = draft.index.at(voxel.x + dx, voxel.y + dy, voxel.z + dz);
        if (other < 0) continue;
        const CcSurface& f =
            draft.pieces[draft.voxels[static_cast<std::size_t>(other)].first].surface;
        if (f.residual > kSmoothResidual) continue;
        all.push_back(continued(f, {float(-dx), float(-dy), float(-dz)}));
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
      sums.push_back({Eigen::Vector3f::Zero(), 0, 0});
    }
    sums[k].n += f.weight * f.n;
    sums[k].s += f.weight * f.s;
    sums[k].weight += f.weight;
  }
  for (Face& f : sums) {
    f.s /= f.weight;
    f.n.normalize();
  }
  return sums;
}

// How much of each sub-sample's little cube a face leaves, for all sub-samples of the block.
// Signed distance in little cubes' widths along the normal, 0 at the face, positive outside.
struct FaceField {
  Face face;
  std::vector<float> outside;
};

FaceField fieldOf(const Face& f) {
  FaceField field{f, std::vector<float>(kPoints)};
  const float scale = kSub / f.n.lpNorm<1>();
  for (int k = 0; k < kPoints; ++k) {
    const Eigen::Vector3f x((float(k % kSubs) + 0.5f) / kSub - 1.5f,
                            (float(k / kSubs % kSubs) + 0.5f) / kSub - 1.5f,
                            (float(k / kSubs / kSubs) + 0.5f) / kSub - 1.5f);
    field.outside[static_cast<std::size_t>(k)] = (f.n.dot(x) - f.s) * scale;
  }
  return field;
}

using Combination = std::vector<const FaceField*>;

// The block's coverage under a combination.
void coverageOf(const Combination& faces, bool concave, float* coverage) {
  std::fill_n(coverage, CC_WINDOW_VOXELS, 0.0f);
  for (int k = 0; k < kPoints; ++k) {
    float out = faces[0]->outside[static_cast<std::size_t>(k)];
    for (std::size_t i = 1; i < faces.size(); ++i) {
      const float other = faces[i]->outside[static_cast<std::size_t>(k)];
      out = concave ? std::min(out, other) : std::max(out, other);
    }
    const int voxel =
        k % kSubs / kSub + 3 * (k / kSubs % kSubs / kSub) + 9 * (k / kSubs / kSubs / kSub);
    coverage[voxel] += std::clamp(0.5f - out, 0.0f, 1.0f) * (1.0f / (kSub * kSub * kSub));
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

struct Hypothesis {
  std::vector<Face> faces;
  bool concave = false;
  float residual = 1.0f;
};

void tryCombination(const float* wanted, const Combination& faces, bool concave, Hypothesis& best) {
  float found[CC_WINDOW_VOXELS];
  coverageOf(faces, concave, found);
  const float residual = blockResidual(wanted, found);
  // A further plane must earn its place.
  if (residual > (faces.size() > best.faces.size() ? 0.8f : 1.0f) * best.residual) return;
  best = {{}, concave, residual};
  for (const FaceField* f : faces) best.faces.push_back(f->face);
}

// Two faces and the plane midway between their normals, where the block's mass wants it.
void tryCrest(const float* wanted, const FaceField& a, const FaceField& b, bool concave,
              Hypothesis& best) {
  const Eigen::Vector3f between = a.face.n + b.face.n;
  if (between.norm() < 0.2f) return;
  float mass = 0;
  for (int k = 0; k < CC_WINDOW_VOXELS; ++k) mass += wanted[k];
  float low = -2, high = 2, found[CC_WINDOW_VOXELS];
  FaceField crest;
  for (int round = 0; round < 10; ++round) {
    crest = fieldOf({between.normalized(), 0.5f * (low + high), 1});
    coverageOf({&a, &b, &crest}, concave, found);
    float sum = 0;
    for (float c : found) sum += c;
    (sum < mass ? low : high) = crest.face.s;
  }
  tryCombination(wanted, {&a, &b, &crest}, concave, best);
}

Hypothesis bestEdge(const float* wanted, const std::vector<Face>& faces) {
  std::vector<FaceField> fields;
  for (const Face& f : faces) fields.push_back(fieldOf(f));
  Hypothesis best;
  for (bool concave : {false, true}) {
    for (std::size_t i = 0; i < fields.size(); ++i)
      for (std::size_t j = i + 1; j < fields.size(); ++j)
        tryCombination(wanted, {&fields[i], &fields[j]}, concave, best);
    for (std::size_t i = 0; i < fields.size(); ++i)
      for (std::size_t j = i + 1; j < fields.size(); ++j)
        for (std::size_t k = j + 1; k < fields.size(); ++k)
          tryCombination(wanted, {&fields[i], &fields[j], &fields[k]}, concave, best);
  }
  if (best.residual < kEdgeResidual) return best;
  for (bool concave : {false, true})
    for (std::size_t i = 0; i < fields.size(); ++i)
      for (std::size_t j = i + 1; j < fields.size(); ++j)
        tryCrest(wanted, fields[i], fields[j], concave, best);
  return best;
}

CcSurface planeSurface(const Face& f, float residual) {
  CcSurface s{};
  for (int i = 0; i < 3; ++i) s.n[i] = f.n[i];
  ccTangents(s.n, s.t1, s.t2);
  s.s = f.s;
  s.residual = residual;
  s.weight = 1;
  return s;
}

}  // namespace

void resolveEdges(FieldDraft& draft) {
  std::vector<Hypothesis> found(draft.voxels.size());
  parallelFor((draft.voxels.size() + 255) / 256, draft.settings.threads,
              [&](std::size_t chunk, int) {
                const std::size_t end = std::min(draft.voxels.size(), (chunk + 1) * 256);
                for (std::size_t i = chunk * 256; i < end; ++i) {
                  const SurfaceVoxel& v = draft.voxels[i];
                  const float residual = draft.pieces[v.first].surface.residual;
                  if (residual <= kSmoothResidual) continue;
                  float block[CC_WINDOW_VOXELS];
                  gatherBlock(draft.cloud, v.x, v.y, v.z, block);
                  Hypothesis h = bestEdge(block, facesNear(draft, v));
                  if (h.residual < kEdgeResidual && h.residual < kEdgeGain * residual)
                    found[i] = std::move(h);
                }
              });
  for (std::size_t i = 0; i < draft.voxels.size(); ++i) {
    SurfaceVoxel& v = draft.voxels[i];
    const Hypothesis& h = found[i];
    v.doubtful = h.faces.empty() && draft.pieces[v.first].surface.residual > kEdgeResidual;
    if (h.faces.empty()) continue;
    v.rule = h.concave ? PieceRule::Concave : PieceRule::Convex;
    v.first = static_cast<std::uint32_t>(draft.pieces.size());
    v.count = static_cast<std::uint32_t>(h.faces.size());
    for (const Face& f : h.faces)
      draft.pieces.push_back({planeSurface(f, h.residual), {0, 0, 0}, 0});
  }
}

}  // namespace cloudcontact
