// The search over pairs and triples of faces, and for a face that no neighbour shows.
#include "field/edge_search.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

// A residual below this explains the block: no other trial is moved into place, no third face
// tried. A box's true planes leave 0.0014 at its edges, 0.004 at most.
constexpr float kExplained = 0.003f;
constexpr float kHidden = 0.006f;       // above this a face is sought that no neighbour shows
constexpr std::size_t kRefined = 2;     // trials of each kind that are moved into place
constexpr std::size_t kWidened = 4;     // pairs that a third face is tried with
constexpr std::size_t kCrestPairs = 3;  // pairs that a crest is sought between
constexpr int kMassRounds = 6;
constexpr float kMiddleMiss = 0.35f;    // of the middle voxel's coverage
constexpr float kFurther = 0.8f;        // a further face must earn its place
constexpr float kBackToBack = -0.8f;    // cosine of a plate's two faces
constexpr float kOneDirection = 0.97f;  // cosine: a sought face is not one of the known again

constexpr float kNeedless = 1.02f;  // a face is left out where that costs less
// All faces together must do this well beside the best few: on ordinary parts nine blocks of ten
// are sent away at once, of those where it succeeds one of twenty.
constexpr float kPromising = 2.0f;

Combination without(const Combination& c, int face) {
  Combination fewer;
  fewer.concave = c.concave;
  for (int i = 0; i < c.count; ++i)
    if (i != face) fewer.face[fewer.count++] = c.face[i];
  measureAngles(fewer);
  return fewer;
}

}  // namespace

Hypothesis EdgeSearch::run(const float* wanted, const std::vector<Face>& faces,
                           const Eigen::Vector3f& mean, TipsTried tips) {
  wanted_ = wanted;
  best_ = {};
  count_ = 0;
  around_.clear();
  for (const Face& f : faces) {
    // A face that passes the block by says nothing of it.
    if (std::abs(f.s) > 1.5f * f.n.lpNorm<1>()) continue;
    if (count_ < kMostNear) fields_[count_++].set(f);
    around_.push_back(f);
  }
  tryPairs();
  pairs_ = trials_;
  refineBest(kRefined);
  if (best_.residual > kExplained) {
    tryTriples();
    refineBest(kRefined);
  }
  if (best_.residual > (tips == TipsTried::Soon ? kExplained : kHidden)) tryTips();
  if (best_.residual > kHidden) trySought(mean);
  return best_;
}

float EdgeSearch::residualOf(const Combination& c) const {
  float found[CC_WINDOW_VOXELS];
  coverageOf(c, found);
  return blockResidual(wanted_, found);
}

// Faces that miss the middle voxel by far are not looked at further: the neighbours' faces are
// right to 0.1 voxel, so what holds shows itself there.
void EdgeSearch::tryOne(const Combination& c) {
  if (std::abs(middleCoverageOf(c) - wanted_[CC_WINDOW_VOXELS / 2]) > kMiddleMiss) return;
  trials_.push_back({c, {}, residualOf(c)});
}

void EdgeSearch::sortTrials() {
  std::stable_sort(trials_.begin(), trials_.end(),
                   [](const Trial& a, const Trial& b) { return a.residual < b.residual; });
}

// All pairs as they stand; the best first.
void EdgeSearch::tryPairs() {
  trials_.clear();
  for (bool concave : {false, true})
    for (int i = 0; i < count_; ++i)
      for (int j = i + 1; j < count_; ++j) tryOne(combine({&fields_[i], &fields_[j]}, concave));
  sortTrials();
}

// Triples: the best pairs and one face more.
void EdgeSearch::tryTriples() {
  trials_.clear();
  for (std::size_t p = 0; p < pairs_.size() && p < kWidened; ++p) {
    const Combination& pair = pairs_[p].faces;
    for (int k = 0; k < count_; ++k)
      if (&fields_[k] != pair.face[0] && &fields_[k] != pair.face[1])
        tryOne(combine({pair.face[0], pair.face[1], &fields_[k]}, pair.concave));
  }
  sortTrials();
}

// Where more faces are around than a record holds, as at the tip of a cone, those that stand for
// all: of the two that look most alike one goes, the lighter, until no more are left than that.
const FaceField* EdgeSearch::spreadFaces() {
  while (around_.size() > kMostFaces) {
    std::size_t drop = 0;
    float most = -2;
    for (std::size_t j = 1; j < around_.size(); ++j)
      for (std::size_t i = 0; i < j; ++i) {
        const float alike = around_[i].n.dot(around_[j].n);
        if (alike <= most) continue;
        most = alike;
        drop = j;  // they stand by their weight
      }
    around_.erase(around_.begin() + static_cast<std::ptrdiff_t>(drop));
  }
  for (std::size_t i = 0; i < kMostFaces; ++i) spread_[i].set(around_[i]);
  return spread_;
}

// More faces than three: at the tip of a slender body all that are near bound it. From all of them
// those are taken away, one by one, without which the block is explained as well.
void EdgeSearch::tryTips() {
  trials_.clear();
  if (count_ <= kFewFaces) return;
  const FaceField* fields = around_.size() > kMostFaces ? spreadFaces() : fields_;
  for (const bool concave : {false, true}) {
    Combination c;
    c.concave = concave;
    for (std::size_t i = 0; i < around_.size(); ++i) c.face[c.count++] = &fields[i];
    measureAngles(c);
    float residual = residualOf(c);
    if (residual > kPromising * best_.residual) continue;
    while (c.count > kFewFaces) {
      Combination best;
      float least = kNeedless * residual;
      for (int i = 0; i < c.count; ++i) {
        const Combination fewer = without(c, i);
        const float r = residualOf(fewer);
        if (r > least) continue;
        least = r;
        best = fewer;
      }
      if (best.count == 0) break;
      c = best;
      residual = least;
    }
    if (c.count > kFewFaces) trials_.push_back({c, {}, residual});
  }
  sortTrials();
  refineBest(kRefined);
}

void EdgeSearch::refineBest(std::size_t most) {
  for (std::size_t t = 0; t < trials_.size() && t < most && best_.residual > kExplained; ++t) {
    const Trial& trial = trials_[t];
    Hypothesis h;
    h.count = trial.faces.count;
    h.concave = trial.faces.concave;
    h.residual = trial.residual;
    for (int i = 0; i < h.count; ++i)
      h.faces[i] = trial.faces.face[i] == &sought_ ? trial.plane : trial.faces.face[i]->face();
    refine(wanted_, h, work_);
    keep(h);
  }
}

void EdgeSearch::keep(const Hypothesis& h) {
  if (h.residual < (h.count > best_.count ? kFurther : 1.0f) * best_.residual) best_ = h;
}

// A face too narrow to be seen on its own: its normal starts midway between two known ones (a
// thread's crest), across two that are back to back (the rim of a plate), or mirrors one about the
// block's mean normal.
void EdgeSearch::trySought(const Eigen::Vector3f& mean) {
  trials_.clear();
  for (std::size_t p = 0; p < pairs_.size() && p < kCrestPairs; ++p) {
    const Combination& pair = pairs_[p].faces;
    const Eigen::Vector3f &a = pair.face[0]->face().n, &b = pair.face[1]->face().n;
    const Eigen::Vector3f across = mean - mean.dot(a) * a;
    guess(combine({pair.face[0], pair.face[1], &sought_}, pair.concave),
          a.dot(b) < kBackToBack ? across : Eigen::Vector3f(a + b));
  }
  for (int i = 0; i < count_; ++i)
    for (bool concave : {false, true})
      guess(combine({&fields_[i], &sought_}, concave),
            2 * mean.dot(fields_[i].face().n) * mean - fields_[i].face().n);
  sortTrials();
  refineBest(kRefined);
}

// Puts the sought face, with the given normal, where the block's mass wants it.
void EdgeSearch::guess(Combination c, const Eigen::Vector3f& normal) {
  if (normal.norm() < 0.2f) return;
  Face plane;
  plane.sought = true;
  plane.n = normal.normalized();
  for (int k = 0; k + 1 < c.count; ++k)
    if (c.face[k]->face().n.dot(plane.n) > kOneDirection) return;
  float mass = 0;
  for (int k = 0; k < CC_WINDOW_VOXELS; ++k) mass += wanted_[k];
  float low = -2, high = 2, found[CC_WINDOW_VOXELS];
  for (int round = 0; round < kMassRounds; ++round) {
    plane.s = 0.5f * (low + high);
    sought_.set(plane);
    if (round == 0) measureAngles(c);
    coverageOf(c, found);
    float sum = 0;
    for (float v : found) sum += v;
    (sum < mass ? low : high) = plane.s;
  }
  trials_.push_back({c, plane, blockResidual(wanted_, found)});
}

}  // namespace cloudcontact
