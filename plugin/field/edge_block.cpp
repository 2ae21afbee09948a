// Coverage of a block by sub-samples. Each is full, empty, or on a ramp that ends half a
// sub-sample's width on either side of the surface.
#include "field/edge_block.h"

#include "base/simd.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstring>

namespace cloudcontact {

namespace {

// A face farther from a voxel's center than this does not cross the voxel, in sub-sample widths:
// half a voxel's edge, the ramp, and the bend of a curvature of 0.3 over half a voxel.
constexpr float kClear = 0.5f * kSub + 0.5f + 0.2f;

// Standard deviations of the target coverage (rounding to 1/255 and the sub-samples' error) and of
// a face's place and tilt as its neighbors know them [voxels, radians]. Their ratio says how firmly
// a face is held. If firmer, the crests of the M16 thread keep 0.1 voxel of error; if looser, the
// two faces of a shallow edge swap places.
constexpr float kCoverageNoise = 0.004f;
constexpr float kPlaceNoise = 0.02f, kTiltNoise = 0.015f;
constexpr float kHiddenNoise = 0.5f;
constexpr int kRounds = 4;
constexpr float kLongestStep = 0.4f;
constexpr float kSettled = 2e-3f;
constexpr float kHopeless = 0.3f;  // residual at which refinement stops

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

// A face, scaled to sub-sample widths along its normal.
struct FaceTerms {
  Eigen::Vector3f n;
  float s;
  bool curved;
  Eigen::Matrix3f half;

  explicit FaceTerms(const Face& f) {
    const float scale = kSub / f.n.lpNorm<1>();
    n = f.n * scale;
    s = f.s * scale;
    curved = !f.curvature.isZero(0);
    half = 0.5f * scale * f.curvature;
  }
  float flat(float x, float y, float z) const { return n.x() * x + n.y() * y + n.z() * z - s; }
  float bent(float x, float y, float z) const {
    return x * (half(0, 0) * x + 2 * half(0, 1) * y) + y * (half(1, 1) * y + 2 * half(1, 2) * z) +
           z * (half(2, 2) * z + 2 * half(0, 2) * x);
  }
  float outside(float x, float y, float z) const {
    return curved ? flat(x, y, z) + bent(x, y, z) : flat(x, y, z);
  }
};

// Distances of a voxel's sub-samples outside a face.
CC_LANES void findOutside(const FaceTerms& terms, int voxel, float* outside) {
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

float windowWeight(int voxel) {
  const float x = middleOf(voxel, 0), y = middleOf(voxel, 1), z = middleOf(voxel, 2);
  const float q = 1.0f - (x * x + y * y + z * z) / CC_WINDOW_RADIUS2;
  return q * q;
}

struct VoxelCase {
  bool uniform = false;  // full or empty
  float coverage = 0;    // if uniform
  int only = -1;         // the one face that crosses the voxel; -1: several do
};

VoxelCase classify(const Combination& c, int voxel) {
  int crossing = 0, face = 0;
  for (int i = 0; i < c.count; ++i) {
    const float middle = c.face[i]->middle(voxel);
    if (c.concave ? middle < -kClear : middle > kClear) return {true, c.concave ? 1.0f : 0.0f, -1};
    if (std::abs(middle) > kClear) continue;
    ++crossing;
    face = i;
  }
  if (crossing == 0) return {true, c.concave ? 0.0f : 1.0f, -1};
  return {false, 0, crossing == 1 ? face : -1};
}

// Derivative of a voxel's coverage as one face shifts outward, and its first moment, which gives
// the derivative as the face turns.
struct Slope {
  float shift = 0;
  Eigen::Vector3f moment = Eigen::Vector3f::Zero();
};

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

// How much of a sub-sample two faces leave together, if each alone leaves r and q: r q for faces at
// right angles, which cut independently; min(r, q) for parallel faces; max(0, r + q - 1) for
// opposite ones. Interpolated by the angle, which is exact where both run through the center. With
// min(r, q) throughout, edges lie 0.03 voxel inside.
Angle angleOf(const Eigen::Vector3f& n, const Eigen::Vector3f& m) {
  const float turn = std::acos(std::clamp(n.dot(m), -1.0f, 1.0f)) * (2.0f / 3.14159265f);
  return {std::max(1.0f - turn, 0.0f), std::max(turn - 1.0f, 0.0f)};
}

// Inlined into the clone that calls it, so that it is compiled for the same instruction set.
#define CC_INLINE [[gnu::always_inline]] inline

struct Joined {
  float both, byFirst, bySecond;  // the share left, and its derivatives by r and q
};

template <bool kSlopes>
CC_INLINE Joined join(float r, float q, float alike, float opposed) {
  const float product = r * q, least = r < q ? r : q, over = r + q - 1.0f;
  const float rest = over > 0.0f ? over : 0.0f;
  Joined j{product + alike * (least - product) + opposed * (rest - product), 0, 0};
  if constexpr (kSlopes) {
    const float free = 1.0f - alike - opposed, apart = over > 0.0f ? opposed : 0.0f;
    j.byFirst = free * q + (r < q ? alike : 0.0f) + apart;
    j.bySecond = free * r + (r < q ? 0.0f : alike) + apart;
  }
  return j;
}

CC_INLINE float clamped(float v) {
  const float low = v > 0.0f ? v : 0.0f;
  return low < 1.0f ? low : 1.0f;
}

// The share of a sub-sample below a face is no linear ramp but an S, more so for oblique faces.
// This cubic has the slope of the closed form in the middle. Linear ramps leave a residual of
// 0.0045 at a box's edges.
CC_INLINE float bent(float r, float bend) {
  return clamped(r + bend * r * (1.0f - r) * (r + r - 1.0f));
}

CC_INLINE float bentSlope(float r, float bend) {
  const float slope = 1.0f + bend * (6.0f * r * (1.0f - r) - 1.0f);
  const float rising = slope > 0.0f ? slope : 0.0f;
  return ((r > 0.0f) & (r < 1.0f)) ? rising : 0.0f;
}

// A number for each of a voxel's sub-samples. Every step runs over all of them before the next one
// starts, so that the compiler vectorizes each step.
struct Lanes {
  alignas(64) float at[kPerVoxel];
};

// Four partial sums, each over every fourth sub-sample. This fixes the order of additions whatever
// the register width.
typedef float F4 __attribute__((vector_size(16)));
CC_INLINE float total(const Lanes& v) {
  F4 sum{};
  for (int k = 0; k < kPerVoxel; k += 4) {
    F4 four;
    std::memcpy(&four, v.at + k, sizeof four);
    sum += four;
  }
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

// How face `j` shares sub-samples with the faces before it: by its angle to the one of them that
// leaves the least there.
CC_INLINE void findAngles(const Combination& c, int j, const Lanes* r, Lanes& alike,
                          Lanes& opposed) {
  Lanes least = r[0];
  for (int k = 0; k < kPerVoxel; ++k) alike.at[k] = c.between(0, j).alike;
  for (int k = 0; k < kPerVoxel; ++k) opposed.at[k] = c.between(0, j).opposed;
  for (int i = 1; i < j; ++i) {
    const Angle angle = c.between(i, j);
    CC_INDEPENDENT
    for (int k = 0; k < kPerVoxel; ++k) {
      const bool former = least.at[k] < r[i].at[k];
      alike.at[k] = former ? alike.at[k] : angle.alike;
      opposed.at[k] = former ? opposed.at[k] : angle.opposed;
      least.at[k] = former ? least.at[k] : r[i].at[k];
    }
  }
}

template <bool kSlopes>
CC_INLINE void joinFace(const Combination& c, int j, const Lanes* r, Lanes& left, Lanes* weight) {
  Lanes alike, opposed, byFirst;
  findAngles(c, j, r, alike, opposed);
  CC_INDEPENDENT
  for (int k = 0; k < kPerVoxel; ++k) {
    const Joined joined = join<kSlopes>(left.at[k], r[j].at[k], alike.at[k], opposed.at[k]);
    left.at[k] = joined.both;
    if constexpr (kSlopes) {
      byFirst.at[k] = joined.byFirst;
      weight[j].at[k] = joined.bySecond;
    }
  }
  if constexpr (kSlopes)
    for (int i = 0; i < j; ++i)
      for (int k = 0; k < kPerVoxel; ++k) weight[i].at[k] *= byFirst.at[k];
}

// From the derivative of each of the voxel's sub-samples.
CC_INLINE Slope slopeOf(const FaceField& face, int voxel, const Lanes& derivative) {
  const Points& points = subSamples();
  float sum[3];
  for (int axis = 0; axis < 3; ++axis) {
    const float* const at = (axis == 0 ? points.x : axis == 1 ? points.y : points.z);
    Lanes moment;
    for (int k = 0; k < kPerVoxel; ++k) moment.at[k] = derivative.at[k] * at[voxel * kPerVoxel + k];
    sum[axis] = total(moment);
  }
  const float scale = kSub / face.face().n.lpNorm<1>() / kPerVoxel;
  return {scale * total(derivative), scale * Eigen::Vector3f(sum[0], sum[1], sum[2])};
}

// The share of each sub-sample that a face alone leaves, and the linear ramp that it derives from.
CC_INLINE void faceShares(const FaceField& face, int voxel, float side, Lanes& ramp, Lanes& left) {
  const float* const outside = face.outside(voxel);
  const float bend = face.bend();
  CC_INDEPENDENT
  for (int k = 0; k < kPerVoxel; ++k) {
    ramp.at[k] = clamped(0.5f + side * outside[k]);
    left.at[k] = bent(ramp.at[k], bend);
  }
}

// A voxel's coverage under two or more faces, and optionally its slopes. A union is computed as the
// intersection of complements.
template <bool kSlopes>
CC_INLINE float voxelCoverage(const Combination& c, int voxel, Slope* slopes) {
  const float side = c.concave ? 1.0f : -1.0f;
  Lanes ramp[kMostFaces], r[kMostFaces], weight[kMostFaces];
  faceShares(*c.face[0], voxel, side, ramp[0], r[0]);
  Lanes left = r[0];
  for (int k = 0; k < kPerVoxel; ++k) weight[0].at[k] = 1.0f;
  for (int j = 1; j < c.count; ++j) {
    faceShares(*c.face[j], voxel, side, ramp[j], r[j]);
    joinFace<kSlopes>(c, j, r, left, weight);
  }
  for (int i = 0; kSlopes && i < c.count; ++i) {
    const float bend = c.face[i]->bend();
    CC_INDEPENDENT
    for (int k = 0; k < kPerVoxel; ++k) weight[i].at[k] *= bentSlope(ramp[i].at[k], bend);
    slopes[i] = slopeOf(*c.face[i], voxel, weight[i]);
  }
  const float share = total(left) * (1.0f / kPerVoxel);
  return c.concave ? 1.0f - share : share;
}

CC_LANES float coverageOnly(const Combination& c, int voxel) {
  return voxelCoverage<false>(c, voxel, nullptr);
}
CC_LANES float coverageAndSlopes(const Combination& c, int voxel, Slope* slopes) {
  return voxelCoverage<true>(c, voxel, slopes);
}

float coverageAt(const Combination& c, int voxel) {
  const VoxelCase kind = classify(c, voxel);
  if (kind.uniform) return kind.coverage;
  return kind.only >= 0 ? c.face[kind.only]->cuts().volume[voxel] : coverageOnly(c, voxel);
}

constexpr int kUnknowns = 3 * kMostFaces;
using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, 0, kUnknowns, kUnknowns>;
using Vector = Eigen::Matrix<float, Eigen::Dynamic, 1, 0, kUnknowns, 1>;
using Tangents = Eigen::Matrix<float, 3, 2>;

Tangents tangentsOf(const Eigen::Vector3f& n) {
  Tangents t;
  t.col(0) = n.unitOrthogonal();
  t.col(1) = n.cross(t.col(0));
  return t;
}

// Normal equations of one round: the prior on each face, then the coverage of each voxel.
struct Equations {
  Matrix left;
  Vector right;

  void addPrior(const Face* now, const Face* first, const Tangents* tangent, int count) {
    left.setZero(3 * count, 3 * count);
    right.setZero(3 * count);
    const auto precision = [](float noise) {
      return (kCoverageNoise / noise) * (kCoverageNoise / noise);
    };
    for (int i = 0; i < count; ++i) {
      const float place = precision(first[i].hidden ? kHiddenNoise : kPlaceNoise),
                  tilt = precision(first[i].hidden ? kHiddenNoise : kTiltNoise);
      const Eigen::Vector2f turned = tangent[i].transpose() * (now[i].n - first[i].n);
      const float off[3] = {now[i].s - first[i].s, turned.x(), turned.y()};
      for (int j = 0; j < 3; ++j) {
        left(3 * i + j, 3 * i + j) = j == 0 ? place : tilt;
        right[3 * i + j] = -(j == 0 ? place : tilt) * off[j];
      }
    }
  }

  // Also returns the coverage found.
  void addCoverage(const float* target, const Combination& c, const Tangents* tangent,
                   float* coverage) {
    Vector g(3 * c.count);
    for (int v = 0; v < CC_WINDOW_VOXELS; ++v) {
      const VoxelCase kind = classify(c, v);
      coverage[v] = kind.coverage;
      if (kind.uniform) continue;
      Slope slope[kMostFaces];
      if (kind.only < 0) {
        coverage[v] = coverageAndSlopes(c, v, slope);
      } else {
        const FaceCuts& cuts = c.face[kind.only]->cuts();
        coverage[v] = cuts.volume[v];
        slope[kind.only] = {cuts.shift[v],
                            {cuts.moment[0][v], cuts.moment[1][v], cuts.moment[2][v]}};
      }
      for (int i = 0; i < c.count; ++i) {
        const Eigen::Vector2f turn = -tangent[i].transpose() * slope[i].moment;
        g.segment<3>(3 * i) << slope[i].shift, turn;
      }
      const float w = windowWeight(v);
      left.noalias() += w * g * g.transpose();
      right.noalias() += w * (target[v] - coverage[v]) * g;
    }
  }
};

}  // namespace

void FaceField::set(const Face& f) {
  face_ = f;
  known_ = 0;
  isCut_ = false;
  const float steep = ccCutCube(f.n.x(), f.n.y(), f.n.z(), 0).area * f.n.lpNorm<1>();
  bend_ = std::max(2 * (steep - 1), 0.0f);
  const FaceTerms terms(f);
  for (int v = 0; v < CC_WINDOW_VOXELS; ++v)
    middle_[static_cast<std::size_t>(v)] =
        terms.outside(middleOf(v, 0), middleOf(v, 1), middleOf(v, 2));
}

void FaceField::cut() const {
  cutWindow(face_, face_.n.lpNorm<1>(), middle_.data(), cuts_);
  isCut_ = true;
}

void FaceField::find(int voxel) const {
  findOutside(FaceTerms(face_), voxel, outside_.data() + voxel * kPerVoxel);
  known_ |= std::uint32_t{1} << voxel;
}

Combination combine(std::initializer_list<const FaceField*> faces, bool concave) {
  Combination c;
  c.concave = concave;
  for (const FaceField* face : faces) c.face[c.count++] = face;
  measureAngles(c);
  return c;
}

void measureAngles(Combination& c) {
  Angle* angle = c.angle;
  for (int j = 1; j < c.count; ++j)
    for (int i = 0; i < j; ++i) *angle++ = angleOf(c.face[i]->face().n, c.face[j]->face().n);
}

void coverageOf(const Combination& c, float* coverage) {
  for (int v = 0; v < CC_WINDOW_VOXELS; ++v) coverage[v] = coverageAt(c, v);
}

float middleCoverageOf(const Combination& c) {
  return coverageAt(c, CC_WINDOW_VOXELS / 2);
}

float blockResidual(const float* target, const float* found) {
  float square = 0, weight = 0;
  for (int v = 0; v < CC_WINDOW_VOXELS; ++v) {
    const float r = target[v] - found[v];
    const bool irrelevant = (found[v] <= 0.0f || found[v] >= 1.0f) && std::abs(r) < 2e-3f;
    if (irrelevant) continue;
    const float w = windowWeight(v);
    square += w * r * r;
    weight += w;
  }
  return weight > 0 ? std::sqrt(square / weight) : 1.0f;
}

void refine(const float* target, Hypothesis& h, FaceField* fields) {
  Combination c;
  c.count = h.count;
  c.concave = h.concave;
  for (int i = 0; i < h.count; ++i) c.face[i] = &fields[i];
  const Hypothesis first = h;
  Hypothesis now = h;
  Tangents tangent[kMostFaces];
  Equations equations;
  for (int round = 0; round <= kRounds; ++round) {
    for (int i = 0; i < h.count; ++i) fields[i].set(now.faces[i]);
    measureAngles(c);
    float found[CC_WINDOW_VOXELS];
    for (int i = 0; i < h.count; ++i) tangent[i] = tangentsOf(now.faces[i].n);
    if (round < kRounds) {
      equations.addPrior(now.faces, first.faces, tangent, h.count);
      equations.addCoverage(target, c, tangent, found);
    } else {
      coverageOf(c, found);
    }
    now.residual = blockResidual(target, found);
    if (now.residual < h.residual) h = now;
    if (round == kRounds || now.residual > kHopeless) return;
    const Vector step = equations.left.ldlt().solve(equations.right);
    if (!step.allFinite()) return;
    const float longest = step.cwiseAbs().maxCoeff();
    if (longest < kSettled) return;
    const float shorten = kLongestStep / std::max(kLongestStep, longest);
    for (int i = 0; i < h.count; ++i) {
      Face& f = now.faces[i];
      f.n += shorten * tangent[i] * step.segment<2>(3 * i + 1);
      f.s = (f.s + shorten * step[3 * i]) / f.n.norm();
      f.n.normalize();
    }
  }
}

}  // namespace cloudcontact
