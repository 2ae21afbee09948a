// Neighbors' surfaces, and which of them are one face.
#include "field/near_faces.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

// Residuals of coverage (kernels/contact/surface_fit.h): smooth surfaces leave 0.001, or 0.003 at a
// radius of 10 voxels; an edge of 20 deg leaves 0.006.
constexpr float kSmoothResidual = 0.004f;
// A quadric that bends more sharply than this [1/voxel] is an edge and no face: a rod of a voxel's
// radius has one. It turned the faces beside it, for it lies within kSameNormal of them.
constexpr float kSharpest = 1.0f;
// A quadric beside an edge bends toward it and still explains its block to the bound above.
// Residuals above this therefore lower a face's weight.
constexpr float kTypical = 0.0005f;
constexpr std::size_t kUsual = 128;     // faces near a voxel, to reserve memory
constexpr float kNoCurvature = 0.012f;  // curvatures below this are noise and are not continued
constexpr float kSameNormal = 0.97f;    // cosine: faces within 14 deg that also coincide are one
constexpr float kSameOffset = 0.25f;

// A neighbor's surface relative to the block's center, which lies at `r` from the neighbor's.
Face continued(const CcSurface& f, const Eigen::Vector3f& r) {
  const Eigen::Map<const Eigen::Vector3f> n(f.n), t1(f.t1), t2(f.t2);
  Face face;
  const float off = f.residual / kTypical;
  face.weight = 1.0f / ((0.5f + r.squaredNorm()) * (1.0f + off * off));
  const bool flat = sharpest(f) < kNoCurvature;
  if (!flat)
    face.curvature = f.k11 * t1 * t1.transpose() + f.k22 * t2 * t2.transpose() +
                     f.k12 * (t1 * t2.transpose() + t2 * t1.transpose());
  const Eigen::Vector3f bent = face.curvature * r, m = n + bent;
  const float length = m.norm();
  face.n = m / length;
  face.s = (f.s - n.dot(r) - 0.5f * r.dot(bent)) / length;
  return face;
}

// The distinct ones of some faces, heaviest first. Each is the weighted mean of those alike.
std::vector<Face> distinct(const std::vector<Face>& all, std::size_t most) {
  // By number, because faces are large; equal ones in their order.
  std::vector<std::pair<float, int>> order;
  order.reserve(all.size());
  for (const Face& f : all) order.emplace_back(-f.weight, static_cast<int>(order.size()));
  std::sort(order.begin(), order.end());
  std::vector<Face> faces, sums;
  faces.reserve(most);
  sums.reserve(most);
  for (const auto& [weight, number] : order) {
    const Face& f = all[static_cast<std::size_t>(number)];
    std::size_t k = 0;
    while (k < faces.size() &&
           !(faces[k].n.dot(f.n) > kSameNormal && std::abs(faces[k].s - f.s) < kSameOffset))
      ++k;
    if (k == faces.size()) {
      if (k == most) continue;
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
    if (f.curvature.cwiseAbs().maxCoeff() < kNoCurvature) f.curvature.setZero();
    f.n.normalize();
  }
  return sums;
}

}  // namespace

bool shows(const VoxelState& v) {
  const CcSurface& own = v.pieces[0].surface;
  if (v.rule() != PieceRule::Smooth) return own.residual <= kGoodEdge;
  return own.residual <= kSmoothResidual && sharpest(own) <= kSharpest;
}

std::vector<Face> facesNear(const FieldDraft& draft, const DraftVoxel& at, int pass,
                            std::size_t most) {
  std::vector<Face> all;
  all.reserve(kUsual);
  anyNear(draft, at, [&](const SurfaceBrick& brick, int cell, const Eigen::Vector3f& offset) {
    const VoxelState from = brick.state(cell, pass);
    if (from && shows(from))
      for (int k = 0; k < from.count(); ++k)
        all.push_back(continued(from.pieces[k].surface, -offset));
    return false;
  });
  return distinct(all, most);
}

}  // namespace cloudcontact
