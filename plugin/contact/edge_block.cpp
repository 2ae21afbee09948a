// Coverage of a block by sub-samples: each is full, empty, or on the ramp of half a sub-sample's
// width on either side of the surface. Four lanes at a time, in a fixed order of summation.
#include "edge_block.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cloudcontact {

namespace {

typedef float F4 __attribute__((vector_size(16)));
typedef int I4 __attribute__((vector_size(16)));
constexpr int kLanes = 4;

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
  alignas(16) float x[kBlockPoints], y[kBlockPoints], z[kBlockPoints];
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

float windowWeight(int voxel) {
  const float x = middleOf(voxel, 0), y = middleOf(voxel, 1), z = middleOf(voxel, 2);
  const float q = 1.0f - (x * x + y * y + z * z) / CC_WINDOW_RADIUS2;
  return q * q;
}

F4 load(const float* p) {
  F4 v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
F4 all(float v) {
  return F4{v, v, v, v};
}
float total(F4 v) {
  return (v[0] + v[1]) + (v[2] + v[3]);
}
F4 masked(F4 v, I4 mask) {
  return reinterpret_cast<F4>(reinterpret_cast<I4>(v) & mask);
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

// A voxel that one face crosses: in closed form, the face flat within it.
float cutVoxel(const FaceField& field, int voxel, Slope* slope) {
  const Face& f = field.face();
  const Eigen::Vector3f x(middleOf(voxel, 0), middleOf(voxel, 1), middleOf(voxel, 2));
  const Eigen::Vector3f m = f.n + f.curvature * x;
  const float length = m.norm(), outside = field.middle(voxel) * f.n.lpNorm<1>() / (kSub * length);
  const CcCut cut = ccCutCube(m.x() / length, m.y() / length, m.z() / length, -outside);
  if (slope) {
    slope->shift = cut.area / length;
    slope->moment = slope->shift * (x - outside * m / length);
  }
  return cut.volume;
}

// How much of a sub-sample two faces leave together, when each alone leaves r and q. Faces at right
// angles cut independently, r q; the same face twice leaves the least of both, and back to back
// faces what they do not cut away between them. Between these by the angle, which is exact where
// both run through the middle. Taking the least throughout put edges 0.03 voxel inside.
Angle angleOf(const Eigen::Vector3f& n, const Eigen::Vector3f& m) {
  const float turn = std::acos(std::clamp(n.dot(m), -1.0f, 1.0f)) * (2.0f / 3.14159265f);
  return {std::max(1.0f - turn, 0.0f), std::max(turn - 1.0f, 0.0f)};
}

struct Joined {
  F4 both, byFirst, bySecond;  // and how that moves with each
};

template <bool kSlopes>
Joined join(F4 r, F4 q, F4 alike, F4 opposed) {
  const F4 product = r * q, least = r < q ? r : q, over = r + q - all(1.0f);
  const F4 rest = over > all(0.0f) ? over : all(0.0f);
  Joined j{product + alike * (least - product) + opposed * (rest - product), {}, {}};
  if constexpr (kSlopes) {
    const F4 free = all(1.0f) - alike - opposed;
    const I4 first = r < q;
    const F4 apart = masked(opposed, over > all(0.0f));
    j.byFirst = free * q + masked(alike, first) + apart;
    j.bySecond = free * r + masked(alike, ~first) + apart;
  }
  return j;
}

F4 within(F4 v) {
  const F4 low = v > all(0.0f) ? v : all(0.0f);
  return low < all(1.0f) ? low : all(1.0f);
}

// The share of a sub-sample below a face is not a straight ramp but an S, the more so the more
// obliquely the face runs: the cubic that is as steep as the closed form in the middle. Straight
// ramps left 0.0045 of residual at a box's edges.
F4 bent(F4 r, F4 bend) {
  const F4 one = all(1.0f);
  return within(r + bend * r * (one - r) * (r + r - one));
}

F4 bentSlope(F4 r, F4 bend) {
  const F4 one = all(1.0f), slope = one + bend * (all(6.0f) * r * (one - r) - one);
  const F4 rising = slope > all(0.0f) ? slope : all(0.0f);
  return masked(rising, (r > all(0.0f)) & (r < one));
}

// How face `j` shares sub-samples with the faces before it: by its angle to the one that matters
// most there, which leaves the least.
template <bool kSlopes>
Joined joinFace(const Combination& c, int j, F4 left, const F4* r) {
  F4 least = r[0], alike = all(c.between(0, j).alike), opposed = all(c.between(0, j).opposed);
  for (int i = 1; i < j; ++i) {
    const I4 former = least < r[i];
    alike = former ? alike : all(c.between(i, j).alike);
    opposed = former ? opposed : all(c.between(i, j).opposed);
    least = former ? least : r[i];
  }
  return join<kSlopes>(left, r[j], alike, opposed);
}

// From sums over the voxel's sub-samples: of how each moves with the face, and that times x, y, z.
Slope slopeOf(const FaceField& face, const F4* sums) {
  const float scale = kSub / face.face().n.lpNorm<1>() / kPerVoxel;
  return {scale * total(sums[0]),
          scale * Eigen::Vector3f(total(sums[1]), total(sums[2]), total(sums[3]))};
}

// A voxel's coverage; and its slopes, where asked for. A union of faces is the intersection of
// their complements.
template <bool kSlopes, int kCount>
float coverVoxel(const Combination& c, int voxel, Slope* slopes) {
  const float side = c.concave ? 1.0f : -1.0f;
  const Points& points = subSamples();
  F4 sum = all(0), moment[kCount][4] = {};
  for (int k = 0; k < kPerVoxel; k += kLanes) {
    F4 ramp[kCount], r[kCount], weight[kCount];
    for (int i = 0; i < kCount; ++i) {
      ramp[i] = within(all(0.5f) + side * load(c.face[i]->outside(voxel) + k));
      r[i] = bent(ramp[i], all(c.face[i]->bend()));
    }
    F4 left = r[0];
    weight[0] = all(1.0f);
    for (int j = 1; j < kCount; ++j) {
      const Joined joined = joinFace<kSlopes>(c, j, left, r);
      left = joined.both;
      if constexpr (kSlopes) {
        for (int i = 0; i < j; ++i) weight[i] *= joined.byFirst;
        weight[j] = joined.bySecond;
      }
    }
    sum += left;
    if constexpr (kSlopes) {
      const int at = voxel * kPerVoxel + k;
      for (int i = 0; i < kCount; ++i) {
        const F4 w = weight[i] * bentSlope(ramp[i], all(c.face[i]->bend()));
        moment[i][0] += w;
        moment[i][1] += w * load(points.x + at);
        moment[i][2] += w * load(points.y + at);
        moment[i][3] += w * load(points.z + at);
      }
    }
  }
  if constexpr (kSlopes)
    for (int i = 0; i < kCount; ++i) slopes[i] = slopeOf(*c.face[i], moment[i]);
  const float share = total(sum) * (1.0f / kPerVoxel);
  return c.concave ? 1.0f - share : share;
}

// The number of faces is known to the compiler: it unrolls what two and three faces, most edges,
// need.
template <bool kSlopes>
float coverVoxel(const Combination& c, int voxel, Slope* slopes) {
  static_assert(kMostFaces == 6);
  switch (c.count) {
    case 2:
      return coverVoxel<kSlopes, 2>(c, voxel, slopes);
    case 3:
      return coverVoxel<kSlopes, 3>(c, voxel, slopes);
    case 4:
      return coverVoxel<kSlopes, 4>(c, voxel, slopes);
    case 5:
      return coverVoxel<kSlopes, 5>(c, voxel, slopes);
    default:
      return coverVoxel<kSlopes, 6>(c, voxel, slopes);
  }
}

float coverageAt(const Combination& c, int voxel) {
  const Sight sight = look(c, voxel);
  if (sight.sure) return sight.coverage;
  return sight.only >= 0 ? cutVoxel(*c.face[sight.only], voxel, nullptr)
                         : coverVoxel<false>(c, voxel, nullptr);
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
      coverage[v] = sight.only >= 0 ? cutVoxel(*c.face[sight.only], v, &slope[sight.only])
                                    : coverVoxel<true>(c, v, slope);
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
  const float steep = ccCutCube(f.n.x(), f.n.y(), f.n.z(), 0).area * f.n.lpNorm<1>();
  bend_ = std::max(2 * (steep - 1), 0.0f);
  const float scale = kSub / f.n.lpNorm<1>();
  const Eigen::Vector3f n = f.n * scale;
  const float s = f.s * scale;
  const Points& points = subSamples();
  for (int k = 0; k < kBlockPoints; ++k)
    outside_[static_cast<std::size_t>(k)] =
        n.x() * points.x[k] + n.y() * points.y[k] + n.z() * points.z[k] - s;
  for (int v = 0; v < CC_WINDOW_VOXELS; ++v)
    middle_[static_cast<std::size_t>(v)] =
        n.x() * middleOf(v, 0) + n.y() * middleOf(v, 1) + n.z() * middleOf(v, 2) - s;
  if (f.curvature.isZero(0)) return;
  const Eigen::Matrix3f half = 0.5f * scale * f.curvature;
  const auto bent = [&](float x, float y, float z) {
    return x * (half(0, 0) * x + 2 * half(0, 1) * y) + y * (half(1, 1) * y + 2 * half(1, 2) * z) +
           z * (half(2, 2) * z + 2 * half(0, 2) * x);
  };
  for (int k = 0; k < kBlockPoints; ++k)
    outside_[static_cast<std::size_t>(k)] += bent(points.x[k], points.y[k], points.z[k]);
  for (int v = 0; v < CC_WINDOW_VOXELS; ++v)
    middle_[static_cast<std::size_t>(v)] += bent(middleOf(v, 0), middleOf(v, 1), middleOf(v, 2));
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
