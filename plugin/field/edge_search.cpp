// The search over pairs, triples and tips, and for a face that no neighbor shows.
#include "field/edge_search.h"

#include "field/edge_estimate.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

// A residual below this explains the block and ends the search. A box's true planes leave 0.0014
// at its edges, 0.004 at most.
constexpr float kExplained = 0.003f;
constexpr float kHidden = 0.006f;  // above this a face that no neighbor shows is tried
// Of hidden faces that must leave less than this, one of fifty is found.
constexpr float kPlain = 0.0035f;
constexpr std::size_t kRefined = 2;     // trials of each kind that are refined
constexpr std::size_t kWidened = 4;     // pairs that a third face is tried with
constexpr std::size_t kCrestPairs = 3;  // pairs that a crest is tried between
constexpr float kCell = 0.125f;         // of the places tried for a hidden face
constexpr float kFarthest = 2;          // of these places
// A trial is refined if its residual is at most this times the useful.
constexpr float kFar = 10.0f, kFarHidden = 16.0f;
// roughResidual() is off by less than this in all but one of ten thousand trials.
constexpr float kRoughError = 0.02f;
constexpr float kMiddleMiss = 0.35f;    // largest error of the middle voxel's coverage in a trial
constexpr float kFurther = 0.8f;        // an additional face must lower the residual by this factor
constexpr float kBackToBack = -0.8f;    // cosine between a plate's two faces
constexpr float kOneDirection = 0.97f;  // cosine: a hidden face must not repeat a known one

constexpr float kNeedless = 1.02f;  // a face is dropped if the residual grows by less than this
// A tip is pursued only if all faces together leave at most this times the residual of the best
// few. This rejects nine blocks of ten on ordinary parts, and one of twenty where a tip is found.
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

Hypothesis EdgeSearch::run(const float* target, const std::vector<Face>& faces,
                           const Eigen::Vector3f& mean, TipsTried tips, float bound) {
  const BlockTarget block(target);
  target_ = &block;
  best_ = {};
  useful_ = bound;
  count_ = 0;
  around_.clear();
  for (const Face& f : faces) {
    // Faces that miss the block do not matter.
    if (std::abs(f.s) > 1.5f * f.n.lpNorm<1>()) continue;
    if (count_ < kMostNear) fields_[count_++].set(f);
    around_.push_back(f);
  }
  tryPairs();
  refineBest();
  if (best_.residual > kExplained) {
    tryTriples();
    refineBest();
  }
  if (best_.residual > (tips == TipsTried::Soon ? kExplained : kHidden)) tryTips();
  if (best_.residual > kHidden && bound > kPlain) tryHidden(mean);
  return best_;
}

// A combination of near faces, by their numbers.
Combination EdgeSearch::combineNear(std::initializer_list<int> faces, bool concave) const {
  Combination c;
  c.concave = concave;
  Angle* angle = c.angle;
  for (auto j = faces.begin(); j != faces.end(); ++j) {
    for (auto i = faces.begin(); i != j; ++i) *angle++ = angles_[*i][*j];
    c.face[c.count++] = &fields_[*j];
  }
  return c;
}

// Makes a combination a candidate if it may leave less than `limit`.
void EdgeSearch::consider(const Combination& c, const Face& plane, float limit) {
  const float least = roughResidual(*target_, c) - kRoughError;
  if (least >= limit) return;
  order_.emplace_back(least, static_cast<int>(candidates_.size()));
  candidates_.push_back({c, plane, least});
}

// Keeps the best `most` candidates as trials, best first. Computes only those whose estimate does
// not exclude them, the most promising first.
void EdgeSearch::choose(std::size_t most, Limits limits) {
  trials_.clear();
  std::sort(order_.begin(), order_.end());
  for (const auto& [least, number] : order_) {
    const bool all = trials_.size() == most;
    const float bound = all ? std::min(limits.residual, trials_.back().residual) : limits.residual;
    if (least >= bound) break;
    const Trial& candidate = candidates_[static_cast<std::size_t>(number)];
    if (candidate.plane.hidden) hidden_.set(candidate.plane);
    const float residual = residualBelow(*target_, candidate.faces, bound, limits.miss);
    if (residual >= bound) continue;
    if (all) trials_.pop_back();
    const auto after = std::find_if(trials_.begin(), trials_.end(),
                                    [&](const Trial& t) { return t.residual > residual; });
    trials_.insert(after, {candidate.faces, candidate.plane, residual});
  }
  order_.clear();
  candidates_.clear();
}

// All pairs, unrefined. Combinations that miss the middle voxel's coverage by far are skipped:
// neighbors' faces are right to 0.1 voxel, so a correct combination is close there.
void EdgeSearch::tryPairs() {
  for (int j = 1; j < count_; ++j)
    for (int i = 0; i < j; ++i) {
      angles_[i][j] = angleBetween(fields_[i], fields_[j]);
      angles_[j][i] = angles_[i][j];
    }
  for (bool concave : {false, true})
    for (int i = 0; i < count_; ++i)
      for (int j = i + 1; j < count_; ++j) consider(combineNear({i, j}, concave), {}, kTooMuch);
  choose(kWidened, {kTooMuch, kMiddleMiss});
  pairs_ = trials_;
}

// The best pairs, each with one more face.
void EdgeSearch::tryTriples() {
  const float limit = kFar * useful_;
  for (const Trial& trial : pairs_) {
    const Combination& pair = trial.faces;
    const int i = static_cast<int>(pair.face[0] - fields_),
              j = static_cast<int>(pair.face[1] - fields_);
    for (int k = 0; k < count_; ++k)
      if (k != i && k != j) consider(combineNear({i, j, k}, pair.concave), {}, limit);
  }
  choose(kRefined, {limit, kMiddleMiss});
}

// Selects faces that represent all, where there are more than a record holds, as at the tip of a
// cone: of the two most alike the lighter is dropped, until few enough are left.
const FaceField* EdgeSearch::spreadFaces() {
  while (around_.size() > kMostEdgeFaces) {
    std::size_t drop = 0;
    float most = -2;
    for (std::size_t j = 1; j < around_.size(); ++j)
      for (std::size_t i = 0; i < j; ++i) {
        const float alike = around_[i].n.dot(around_[j].n);
        if (alike <= most) continue;
        most = alike;
        drop = j;  // sorted by weight
      }
    around_.erase(around_.begin() + static_cast<std::ptrdiff_t>(drop));
  }
  for (std::size_t i = 0; i < kMostEdgeFaces; ++i) spread_[i].set(around_[i]);
  return spread_;
}

// More than three faces: all faces near the tip of a slender body bound it. Starts with all of them
// and drops, one by one, those that do not improve the fit.
void EdgeSearch::tryTips() {
  trials_.clear();
  if (count_ <= kFewFaces) return;
  const FaceField* fields = around_.size() > kMostEdgeFaces ? spreadFaces() : fields_;
  for (const bool concave : {false, true}) {
    Combination c;
    c.concave = concave;
    for (std::size_t i = 0; i < around_.size(); ++i) c.face[c.count++] = &fields[i];
    measureAngles(c);
    const float promising = std::min(kPromising * best_.residual, kFar * useful_);
    if (roughResidual(*target_, c) - 2 * kRoughError > promising) continue;
    float residual = residualBelow(*target_, c, std::nextafter(promising, kTooMuch), kTooMuch);
    if (residual > promising) continue;
    while (c.count > kFewFaces) {
      Combination best;
      float least = kNeedless * residual;
      for (int i = 0; i < c.count; ++i) {
        const Combination fewer = without(c, i);
        const float r = residualBelow(*target_, fewer, std::nextafter(least, kTooMuch), kTooMuch);
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
  std::stable_sort(trials_.begin(), trials_.end(),
                   [](const Trial& a, const Trial& b) { return a.residual < b.residual; });
  refineBest();
}

void EdgeSearch::refineBest() {
  for (std::size_t t = 0; t < trials_.size() && t < kRefined && best_.residual > kExplained; ++t) {
    const Trial& trial = trials_[t];
    if (trial.residual > (trial.plane.hidden ? kFarHidden : kFar) * useful_) break;
    Hypothesis h;
    h.count = trial.faces.count;
    h.concave = trial.faces.concave;
    h.residual = trial.residual;
    if (trial.plane.hidden) hidden_.set(trial.plane);
    for (int i = 0; i < h.count; ++i) h.faces[i] = trial.faces.face[i]->face();
    const float beat = (h.count > best_.count ? kFurther : 1.0f) * best_.residual;
    refine(*target_, std::min(useful_, beat), trial.faces, h, work_);
    keep(h);
  }
}

void EdgeSearch::keep(const Hypothesis& h) {
  if (h.residual < (h.count > best_.count ? kFurther : 1.0f) * best_.residual) best_ = h;
}

// A face too narrow for a fit of its own. Its normal starts midway between two known ones (crest of
// a thread), across two that are back to back (rim of a plate), or as one mirrored about the
// block's mean normal.
void EdgeSearch::tryHidden(const Eigen::Vector3f& mean) {
  for (std::size_t p = 0; p < pairs_.size() && p < kCrestPairs; ++p) {
    const Combination& pair = pairs_[p].faces;
    const Eigen::Vector3f &a = pair.face[0]->face().n, &b = pair.face[1]->face().n;
    const Eigen::Vector3f across = mean - mean.dot(a) * a;
    placeHidden(combine({pair.face[0], pair.face[1], &hidden_}, pair.concave),
                a.dot(b) < kBackToBack ? across : Eigen::Vector3f(a + b));
  }
  for (int i = 0; i < count_; ++i)
    for (bool concave : {false, true})
      placeHidden(combine({&fields_[i], &hidden_}, concave),
                  2 * mean.dot(fields_[i].face().n) * mean - fields_[i].face().n);
  choose(kRefined, {kFarHidden * useful_, kTooMuch});
  refineBest();
}

// Tries a hidden face with the given normal, the last of the combination, where it makes the
// block's mass right.
void EdgeSearch::placeHidden(Combination c, const Eigen::Vector3f& normal) {
  if (normal.norm() < 0.2f) return;
  Face plane;
  plane.hidden = true;
  plane.n = normal.normalized();
  for (int k = 0; k + 1 < c.count; ++k)
    if (c.face[k]->face().n.dot(plane.n) > kOneDirection) return;
  hidden_.set(plane);
  measureAngles(c);
  plane.s = placeOf(c);
  hidden_.set(plane);
  measureAngles(c);
  consider(c, plane, kFarHidden * useful_);
}

// The middle of the cell of places in which the mass is right. Taken by secants that no end of the
// range keeps for long (Illinois).
float EdgeSearch::placeOf(const Combination& c) const {
  const auto off = [&](float place) { return roughMass(c, place) - target_->mass; };
  float low = -kFarthest, high = kFarthest, below = off(low), above = off(high);
  if (below >= 0) return low + 0.5f * kCell;
  if (above < 0) return high - 0.5f * kCell;
  int last = 0;
  while (high - low > 1.5f * kCell) {
    const float part = std::clamp(below / (below - above), 0.1f, 0.9f);
    const float place = std::clamp(kCell * std::round((low + part * (high - low)) / kCell),
                                   low + kCell, high - kCell);
    const float now = off(place);
    const int side = now < 0 ? -1 : 1;
    (now < 0 ? low : high) = place;
    (now < 0 ? below : above) = now;
    if (side == last) (now < 0 ? above : below) *= 0.5f;
    last = side;
  }
  return 0.5f * (low + high);
}

}  // namespace cloudcontact
