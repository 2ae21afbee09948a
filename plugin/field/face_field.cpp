// Distances outside a face, and cuts of voxels in closed form.
#include "field/face_field.h"

#include "base/simd.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

// A face farther from a voxel's center than this does not cross the voxel, in sub-sample widths:
// half a voxel's edge, the ramp, and the bend of a curvature of 0.3 over half a voxel.
constexpr float kClear = 0.5f * kSub + 0.5f + 0.2f;

struct Points {
  alignas(64) float x[kBlockPoints], y[kBlockPoints], z[kBlockPoints];
};

float middleOf(int voxel, int axis) {
  const int at[3] = {voxel % 3, voxel / 3 % 3, voxel / 9};
  return static_cast<float>(at[axis] - 1);
}

// Positions of the sub-samples, in the order of FaceField.
const Points& subSamples() {
  static const Points points = [] {
    Points p;
    for (int k = 0; k < kBlockPoints; ++k) {
      const int voxel = k / kPerVoxel, sub = k % kPerVoxel;
      const auto at = [&](int axis, int step) {
        return middleOf(voxel, axis) - 0.5f + (static_cast<float>(step) + 0.5f) / kSub;
      };
      p.x[k] = at(0, sub % kSub);
      p.y[k] = at(1, sub / kSub % kSub);
      p.z[k] = at(2, sub / kSub / kSub);
    }
    return p;
  }();
  return points;
}

// Distances of a voxel's sub-samples outside a face.
CC_LANES [[gnu::flatten]] void findOutside(const FaceTerms& face, int voxel, float* outside) {
  const FaceTerms terms = face;  // a copy, which `outside` cannot share
  const Points& points = subSamples();
  const float *x = points.x + voxel * kPerVoxel, *y = points.y + voxel * kPerVoxel,
              *z = points.z + voxel * kPerVoxel;
  if (terms.curved) {
    CC_INDEPENDENT
    for (int k = 0; k < kPerVoxel; ++k)
      outside[k] = terms.flat(x[k], y[k], z[k]) + terms.bent(x[k], y[k], z[k]);
  } else {
    CC_INDEPENDENT
    for (int k = 0; k < kPerVoxel; ++k) outside[k] = terms.flat(x[k], y[k], z[k]);
  }
}

CC_LANES [[gnu::flatten]] void cutWindow(const Face& f, float length1, const float* middle,
                                         FaceCuts& cuts) {
  const float n[3] = {f.n.x(), f.n.y(), f.n.z()};
  float c[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) c[i][j] = f.curvature(i, j);
  CC_INDEPENDENT
  for (int k = 0; k < CC_WINDOW_LANES; ++k) {
    const float x = static_cast<float>(k % 3 - 1), y = static_cast<float>(k / 3 % 3 - 1),
                z = static_cast<float>(k / 9 - 1);
    const float mx = n[0] + (c[0][0] * x + (c[0][1] * y + c[0][2] * z));
    const float my = n[1] + (c[1][0] * x + (c[1][1] * y + c[1][2] * z));
    const float mz = n[2] + (c[2][0] * x + (c[2][1] * y + c[2][2] * z));
    const float length = std::sqrt(mx * mx + (my * my + mz * mz));
    const float outside = middle[k] * length1 / (kSub * length);
    const CcCut cut = ccCutCube(mx / length, my / length, mz / length, -outside);
    const float shift = cut.area / length;
    cuts.volume[k] = cut.volume;
    cuts.shift[k] = shift;
    cuts.moment[0][k] = shift * (x - outside * mx / length);
    cuts.moment[1][k] = shift * (y - outside * my / length);
    cuts.moment[2][k] = shift * (z - outside * mz / length);
  }
}

// The distances at the voxels' centers, and by them the voxels that lie wholly outside or inside.
CC_LANES [[gnu::flatten]] void findMiddles(const FaceTerms& face, float* middle,
                                           std::uint32_t& outer, std::uint32_t& inner) {
  const FaceTerms terms = face;  // a copy, which `middle` cannot share
  CC_INDEPENDENT
  for (int k = 0; k < CC_WINDOW_LANES; ++k) {
    const float x = static_cast<float>(k % 3 - 1), y = static_cast<float>(k / 3 % 3 - 1),
                z = static_cast<float>(k / 9 - 1);
    middle[k] = terms.flat(x, y, z) + terms.bent(x, y, z);
  }
  std::uint32_t above = 0, below = 0;
  for (std::uint32_t k = 0; k < CC_WINDOW_LANES; ++k) {
    above |= middle[k] > kClear ? 1u << k : 0u;
    below |= middle[k] < -kClear ? 1u << k : 0u;
  }
  outer = above & kAllVoxels;
  inner = below & kAllVoxels;
}

}  // namespace

FaceTerms::FaceTerms(const Face& f) {
  const float scale = kSub / f.n.lpNorm<1>();
  n = f.n * scale;
  s = f.s * scale;
  curved = !f.curvature.isZero(0);
  half = 0.5f * scale * f.curvature;
}

void FaceField::set(const Face& f) {
  face_ = f;
  terms_ = FaceTerms(f);
  known_ = 0;
  isCut_ = false;
  perShift_ = kSub / f.n.lpNorm<1>();
  bend_ = -1;
  findMiddles(terms_, middle_.data(), outer_, inner_);
}

void FaceField::cut() const {
  cutWindow(face_, face_.n.lpNorm<1>(), middle_.data(), cuts_);
  isCut_ = true;
}

void FaceField::find(int voxel) const {
  if (bend_ < 0) {
    const float steep = ccCutCube(face_.n.x(), face_.n.y(), face_.n.z(), 0).area;
    bend_ = std::max(2 * (steep * face_.n.lpNorm<1>() - 1), 0.0f);
  }
  findOutside(terms_, voxel, outside_.data() + voxel * kPerVoxel);
  known_ |= std::uint32_t{1} << voxel;
}

}  // namespace cloudcontact
