// The rounds of Gauss-Newton.
#include "field/edge_refine.h"

#include "base/simd.h"

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <cmath>

namespace cloudcontact {

namespace {

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
// Refinement also stops where it foresees a residual so large that this share of it would still be
// useless, in each round. Of the hypotheses that refinement makes useful, it stops one of fifty.
constexpr float kLeast[] = {0.5f, 0.75f, 0.85f, 0.95f}, kLeastHidden[] = {0.25f, 0.5f, 0.7f, 0.9f};

constexpr int kUnknowns = 3 * kMostEdgeFaces;
constexpr int kRows = 24;  // whole vector registers
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
  int unknowns = 0, rows = 0;  // rows: rounded up to whole registers
  alignas(64) float left[kUnknowns][kRows], right[kRows];
  float prior[kUnknowns], pull[kUnknowns];  // the prior's part of left's diagonal and of right

  explicit Equations(int count) : unknowns(3 * count), rows((3 * count + 7) / 8 * 8) {}

  void clear() {
    for (int j = 0; j < unknowns; ++j) std::fill(left[j], left[j] + rows, 0.0f);
    std::fill(right, right + rows, 0.0f);
  }

  void addPrior(const Face* now, const Face* first, const Tangents* tangent) {
    const auto precision = [](float noise) {
      return (kCoverageNoise / noise) * (kCoverageNoise / noise);
    };
    for (int i = 0; 3 * i < unknowns; ++i) {
      const float place = precision(first[i].hidden ? kHiddenNoise : kPlaceNoise),
                  tilt = precision(first[i].hidden ? kHiddenNoise : kTiltNoise);
      const Eigen::Vector2f turned = tangent[i].transpose() * (now[i].n - first[i].n);
      const float off[3] = {now[i].s - first[i].s, turned.x(), turned.y()};
      for (int j = 0; j < 3; ++j) {
        const int k = 3 * i + j;
        left[k][k] = prior[k] = j == 0 ? place : tilt;
        right[k] = pull[k] = -prior[k] * off[j];
      }
    }
  }

  // Also returns the coverage found.
  void addCoverage(const BlockTarget& target, const Combination& c, const Tangents* tangent,
                   float* coverage);

  // By L D L^T. Not finite where a pivot vanishes.
  Vector solved() const {
    float l[kUnknowns][kUnknowns], d[kUnknowns];
    Vector x(unknowns);
    for (int i = 0; i < unknowns; ++i) {
      d[i] = left[i][i];
      x[i] = right[i];
      for (int j = 0; j < i; ++j) {
        float sum = left[j][i];  // l[i][j] d[j]
        for (int k = 0; k < j; ++k) sum -= l[i][k] * d[k] * l[j][k];
        l[i][j] = sum / d[j];
        d[i] -= l[i][j] * sum;
        x[i] -= l[i][j] * x[j];
      }
    }
    for (int i = unknowns; i-- > 0;) {
      x[i] /= d[i];
      for (int k = i + 1; k < unknowns; ++k) x[i] -= l[k][i] * x[k];
    }
    return x;
  }
};

// Adds w g g^T and w r g.
CC_LANES void addVoxel(Equations& e, const float* g, float w, float r) {
  alignas(64) float weighted[kRows];
  for (int i = 0; i < kRows; ++i) weighted[i] = w * g[i];
  const float pull = w * r;
  for (int j = 0; j < e.unknowns; ++j) {
    const float by = g[j];
    float* const column = e.left[j];
    CC_INDEPENDENT
    for (int i = 0; i < e.rows; ++i) column[i] += by * weighted[i];
  }
  CC_INDEPENDENT
  for (int i = 0; i < e.rows; ++i) e.right[i] += pull * g[i];
}

void Equations::addCoverage(const BlockTarget& target, const Combination& c,
                            const Tangents* tangent, float* coverage) {
  const BlockCases cases = coverSimple(c, coverage);
  std::uint32_t crossed = cases.several;
  for (int i = 0; i < c.count; ++i) crossed |= cases.only[i];
  for (; crossed != 0; crossed &= crossed - 1) {
    const int v = std::countr_zero(crossed);
    Slope slope[kMostEdgeFaces];
    if (cases.several >> v & 1) {
      coverage[v] = coverageAndSlopes(c, v, slope);
    } else {
      int i = 0;
      while (!(cases.only[i] >> v & 1)) ++i;
      const FaceCuts& cuts = c.face[i]->cuts();
      coverage[v] = cuts.volume[v];
      slope[i] = {cuts.shift[v], {cuts.moment[0][v], cuts.moment[1][v], cuts.moment[2][v]}};
    }
    alignas(64) float g[kRows] = {};
    for (int i = 0; i < c.count; ++i) {
      const Eigen::Vector2f turn = -tangent[i].transpose() * slope[i].moment;
      g[3 * i] = slope[i].shift;
      g[3 * i + 1] = turn.x();
      g[3 * i + 2] = turn.y();
    }
    addVoxel(*this, g, windowWeight(v), target.coverage[v] - coverage[v]);
  }
}

// Residual that a step would leave if the coverage were linear in it.
float foreseen(const Equations& e, const BlockError& now, const Vector& step) {
  float square = now.square;
  for (int j = 0; j < e.unknowns; ++j) {
    float row = -e.prior[j] * step[j];
    for (int i = 0; i < e.unknowns; ++i) row += e.left[j][i] * step[i];
    square += step[j] * (row - 2 * (e.right[j] - e.pull[j]));
  }
  return now.weight > 0 ? std::sqrt(std::max(square, 0.0f) / now.weight) : 0.0f;
}

// Moves the faces by a step of the unknowns.
void move(Face* faces, int count, const Tangents* tangent, const Vector& step, float shorten) {
  for (int i = 0; i < count; ++i) {
    Face& f = faces[i];
    f.n += shorten * tangent[i] * step.segment<2>(3 * i + 1);
    f.s = (f.s + shorten * step[3 * i]) / f.n.norm();
    f.n.normalize();
  }
}

}  // namespace

void refine(const BlockTarget& target, float useful, const Combination& start, Hypothesis& h,
            FaceField* fields) {
  Combination c = start;
  const Hypothesis first = h;
  Hypothesis now = h;
  Tangents tangent[kMostEdgeFaces];
  Equations equations(h.count);
  const auto isHidden = [](const Face& f) { return f.hidden; };
  const float* const least =
      h.count > 3 || std::any_of(h.faces, h.faces + h.count, isHidden) ? kLeastHidden : kLeast;
  for (int round = 0; round <= kRounds; ++round) {
    for (int i = 0; round > 0 && i < h.count; ++i) {
      fields[i].set(now.faces[i]);
      c.face[i] = &fields[i];
    }
    if (round > 0) measureAngles(c);
    float found[CC_WINDOW_VOXELS];
    for (int i = 0; i < h.count; ++i) tangent[i] = tangentsOf(now.faces[i].n);
    if (round < kRounds) {
      equations.clear();
      equations.addPrior(now.faces, first.faces, tangent);
      equations.addCoverage(target, c, tangent, found);
    } else {
      coverageOf(c, found);
    }
    const BlockError error = blockError(target.coverage, found);
    now.residual = error.residual();
    if (now.residual < h.residual) h = now;
    if (round == kRounds || now.residual > kHopeless) return;
    const Vector step = equations.solved();
    if (!step.allFinite()) return;
    const float longest = step.cwiseAbs().maxCoeff();
    if (longest < kSettled) return;
    const float shorten = kLongestStep / std::max(kLongestStep, longest);
    if (least[round] * foreseen(equations, error, shorten * step) > useful) return;
    move(now.faces, h.count, tangent, step, shorten);
  }
}

}  // namespace cloudcontact
