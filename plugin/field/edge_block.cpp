// Coverage of a block by sub-samples: each is full, empty, or on the ramp of half a sub-sample's
// width on either side of the surface.
#include "field/edge_block.h"

#include "base/simd.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cloudcontact {

namespace {

// In sub-sample widths: a voxel's corner is half its edge away, then the ramp, then what a
// curvature of 0.3 bends over half a voxel.
constexpr float kClear = 0.5f * kSub + 0.5f + 0.2f;

// Deviations that the wanted coverage (1/255, and the sub-samples' own error) leaves open, over
// those that a face's neighbours leave [voxels, radians]: how firmly a face is held. Firmer than
// this the M16 thread's crests keep 0.1 voxel of error, looser the two faces of a shallow edge
// trade places.
constexpr float kCoverageNoise = 0.004f;
constexpr float kPlaceNoise = 0.02f, kTiltNoise = 0.015f;
constexpr float kSoughtNoise = 0.5f;
constexpr int kRounds = 4;
constexpr float kLongestStep = 0.4f;
constexpr float kSettled = 2e-3f;
constexpr float kHopeless = 0.3f;  // residual at which it is given up

struct Points {
  alignas(64) float x[kBlockPoints], y[kBlockPoints], z[kBlockPoints];
};

float middleOf(int voxel, int axis) {
  const int at[3] = {voxel % 3, voxel / 3 % 3, voxel / 9};
  return static_cast<float>(at[axis] - 1);
}

// Where the sub-samples lie, in the order of FaceField.
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

// A face in sub-sample widths along its normal.
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

// How far a voxel's sub-samples lie outside a face.
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

// What becomes of a voxel.
struct Sight {
  bool sure = false;  // full or empty, and which
  float coverage = 0;
  int only = -1;  // the one face that crosses it, -1: several do
};

Sight look(const Combination& c, int voxel) {
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

// How a voxel's coverage moves with one face: as the face shifts outwards, and that times the place
// where it does so, as turning the face asks.
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

// How much of a sub-sample two faces leave together, when each alone leaves r and q. Faces at right
// angles cut independently, r q; the same face twice leaves the least of both, and back to back
// faces what they do not cut away between them. Between these by the angle, which is exact where
// both run through the middle. Taking the least throughout put edges 0.03 voxel inside.
Angle angleOf(const Eigen::Vector3f& n, const Eigen::Vector3f& m) {
  const float turn = std::acos(std::clamp(n.dot(m), -1.0f, 1.0f)) * (2.0f / 3.14159265f);
  return {std::max(1.0f - turn, 0.0f), std::max(turn - 1.0f, 0.0f)};
}

// What becomes part of the clone that calls it.
#define CC_INLINE [[gnu::always_inline]] inline

struct Joined {
  float both, byFirst, bySecond;  // and how that moves with each
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

CC_INLINE float within(float v) {
  const float low = v > 0.0f ? v : 0.0f;
  return low < 1.0f ? low : 1.0f;
}

// The share of a sub-sample below a face is not a straight ramp but an S, the more so the more
// obliquely the face runs: the cubic that is as steep as the closed form in the middle. Straight
// ramps left 0.0045 of residual at a box's edges.
CC_INLINE float bent(float r, float bend) {
  return within(r + bend * r * (1.0f - r) * (r + r - 1.0f));
}

CC_INLINE float bentSlope(float r, float bend) {
  const float slope = 1.0f + bend * (6.0f * r * (1.0f - r) - 1.0f);
  const float rising = slope > 0.0f ? slope : 0.0f;
  return ((r > 0.0f) & (r < 1.0f)) ? rising : 0.0f;
}

// A number for each of a voxel's sub-samples. What is done to them is done to all, one step after
// the other: so the compiler makes whole registers of each step, which it did not of sixteen or
// four sub-samples on their way through all steps.
struct Lanes {
  alignas(64) float at[kPerVoxel];
};

// Four sums, each of every fourth sub-sample in their order: that, and not the registers, is what
// results depend on.
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

// How face `j` shares sub-samples with the faces before it: by its angle to the one that matters
// most there, which leaves the least.
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

// From how each of the voxel's sub-samples moves with the face.
CC_INLINE Slope slopeOf(const FaceField& face, int voxel, const Lanes& moves) {
  const Points& points = subSamples();
  float sum[3];
  for (int axis = 0; axis < 3; ++axis) {
    const float* const at = (axis == 0 ? points.x : axis == 1 ? points.y : points.z);
    Lanes moment;
    for (int k = 0; k < kPerVoxel; ++k) moment.at[k] = moves.at[k] * at[voxel * kPerVoxel + k];
    sum[axis] = total(moment);
  }
  const float scale = kSub / face.face().n.lpNorm<1>() / kPerVoxel;
  return {scale * total(moves), scale * Eigen::Vector3f(sum[0], sum[1], sum[2])};
}

// What a face alone leaves of a voxel's sub-samples, and the ramp that it is bent from.
CC_INLINE void leave(const FaceField& face, int voxel, float side, Lanes& ramp, Lanes& left) {
  const float* const outside = face.outside(voxel);
  const float bend = face.bend();
  CC_INDEPENDENT
  for (int k = 0; k < kPerVoxel; ++k) {
    ramp.at[k] = within(0.5f + side * outside[k]);
    left.at[k] = bent(ramp.at[k], bend);
  }
}

// A voxel's coverage by two faces or more; and its slopes, where asked for. A union of faces is the
// intersection of their complements.
template <bool kSlopes>
CC_INLINE float coverVoxel(const Combination& c, int voxel, Slope* slopes) {
  const float side = c.concave ? 1.0f : -1.0f;
  Lanes ramp[kMostFaces], r[kMostFaces], weight[kMostFaces];
  leave(*c.face[0], voxel, side, ramp[0], r[0]);
  Lanes left = r[0];
  for (int k = 0; k < kPerVoxel; ++k) weight[0].at[k] = 1.0f;
  for (int j = 1; j < c.count; ++j) {
    leave(*c.face[j], voxel, side, ramp[j], r[j]);
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

CC_LANES float coverOnly(const Combination& c, int voxel) {
  return coverVoxel<false>(c, voxel, nullptr);
}
CC_LANES float coverWithSlopes(const Combination& c, int voxel, Slope* slopes) {
  return coverVoxel<true>(c, voxel, slopes);
}

float coverageAt(const Combination& c, int voxel) {
  const Sight sight = look(c, voxel);
  if (sight.sure) return sight.coverage;
  return sight.only >= 0 ? c.face[sight.only]->cuts().volume[voxel] : coverOnly(c, voxel);
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

// One round's normal equations: coverage wanted, and each face where it was at first.
struct Equations {
  Matrix left;
  Vector right;

  void hold(const Face* now, const Face* first, const Tangents* tangent, int count) {
    left.setZero(3 * count, 3 * count);
    right.setZero(3 * count);
    const auto precision = [](float noise) {
      return (kCoverageNoise / noise) * (kCoverageNoise / noise);
    };
    for (int i = 0; i < count; ++i) {
      const float place = precision(first[i].sought ? kSoughtNoise : kPlaceNoise),
                  tilt = precision(first[i].sought ? kSoughtNoise : kTiltNoise);
      const Eigen::Vector2f turned = tangent[i].transpose() * (now[i].n - first[i].n);
      const float off[3] = {now[i].s - first[i].s, turned.x(), turned.y()};
      for (int j = 0; j < 3; ++j) {
        left(3 * i + j, 3 * i + j) = j == 0 ? place : tilt;
        right[3 * i + j] = -(j == 0 ? place : tilt) * off[j];
      }
    }
  }

  // Also tells the coverage found.
  void see(const float* wanted, const Combination& c, const Tangents* tangent, float* coverage) {
    Vector g(3 * c.count);
    for (int v = 0; v < CC_WINDOW_VOXELS; ++v) {
      const Sight sight = look(c, v);
      coverage[v] = sight.coverage;
      if (sight.sure) continue;
      Slope slope[kMostFaces];
      if (sight.only < 0) {
        coverage[v] = coverWithSlopes(c, v, slope);
      } else {
        const FaceCuts& cuts = c.face[sight.only]->cuts();
        coverage[v] = cuts.volume[v];
        slope[sight.only] = {cuts.shift[v],
                             {cuts.moment[0][v], cuts.moment[1][v], cuts.moment[2][v]}};
      }
      for (int i = 0; i < c.count; ++i) {
        const Eigen::Vector2f turn = -tangent[i].transpose() * slope[i].moment;
        g.segment<3>(3 * i) << slope[i].shift, turn;
      }
      const float w = windowWeight(v);
      left.noalias() += w * g * g.transpose();
      right.noalias() += w * (wanted[v] - coverage[v]) * g;
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

float blockResidual(const float* wanted, const float* found) {
  float square = 0, weight = 0;
  for (int v = 0; v < CC_WINDOW_VOXELS; ++v) {
    const float r = wanted[v] - found[v];
    const bool silent = (found[v] <= 0.0f || found[v] >= 1.0f) && std::abs(r) < 2e-3f;
    if (silent) continue;
    const float w = windowWeight(v);
    square += w * r * r;
    weight += w;
  }
  return weight > 0 ? std::sqrt(square / weight) : 1.0f;
}

void refine(const float* wanted, Hypothesis& h, FaceField* fields) {
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
      equations.hold(now.faces, first.faces, tangent, h.count);
      equations.see(wanted, c, tangent, found);
    } else {
      coverageOf(c, found);
    }
    now.residual = blockResidual(wanted, found);
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
