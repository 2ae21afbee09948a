// Both directions of a search, from few samples to all.
#include "contact/hit_search.h"

#include <cloudcontact/contact/paper_body.h>

#include "contact/level_search.h"
#include "kernels/contact/hit_bins.h"

namespace cloudcontact {

namespace {

using namespace search;

// [voxels] Bodies this far apart have neither hits nor near misses: a sample reaches less than two
// voxels from its middle.
constexpr double kFarApart = 5;

const FieldData& dataOf(const ContactBody& body) {
  return body.field->data();
}

// A near miss as the hit that it is once the bodies have come nearer by `shift` [m], clipped as any
// hit. It lies midway between the surfaces as they are.
Hit movedIn(const NearMiss& miss, float shift) {
  Hit hit = miss.hit;
  const CcWet wet = ccWet(hit.depth + shift, miss.spread);
  hit.position -= 0.5f * (wet.middle - shift) * hit.own;
  hit.depth += shift;
  hit.share = wet.share;
  hit.depth1 = wet.depth1, hit.depth2 = wet.depth2, hit.depth3 = wet.depth3;
  return hit;
}

// Whether a near miss that is moved in faces the other body. What does not, as the sides of a box
// over a table, presses nothing, and which of it the search finds is chance.
bool faces(const Hit& hit) {
  return hit.facing > CC_ACROSS;
}

}  // namespace

bool wantsVoxels(const ContactBody& own) {
  return own.field && (own.paper || (own.tissues && own.tissues->size() > 1));
}

const PlacedSolid* areaOf(const ContactBody& body) {
  return body.paper && body.paper->area ? &*body.paper->area : nullptr;
}

struct HitSearch::Query {
  const ContactBody* bodies[2];
  CcWay ways[2];  // of each body's samples, if it has a field
  std::size_t enough;
  const OwnedVoxels* owned[2] = {nullptr, nullptr};  // where the touched ones are wanted
};

HitSearch::Query HitSearch::queryOf(const ContactBody& a, const ContactBody& b,
                                    const PairFrame& frame, std::size_t enough) {
  Query query{{&a, &b}, {}, enough};
  for (const Side side : {kA, kB}) {
    const ContactBody &own = *query.bodies[side], &other = *query.bodies[1 - side];
    if (wantsVoxels(own) && !areaOf(other)) query.owned[side] = &ownedVoxels(dataOf(own));
  }
  if (a.field) query.ways[kA] = wayOf(a, b, frame);
  if (b.field) query.ways[kB] = wayOf(b, a, frame);
  return query;
}

void HitSearch::searchSide(const Query& query, Side side, int level, HitColumns& hits) {
  const ContactBody &own = *query.bodies[side], &other = *query.bodies[1 - side];
  if (!own.field) return;
  const FieldData& samples = dataOf(own);
  const float voxel = static_cast<float>(samples.cloud().voxelSize());
  const Direction dir{query.ways[side],
                      samples,
                      samples.samples(),
                      level,
                      side,
                      voxel,
                      neededOf(level, query.enough),
                      query.owned[side]};
  if (!other.shape) return searchField(dir, dataOf(other), candidates_[side], hits, shares_);
  searchShape(dir, *other.shape, toShapeOf(own, other), candidates_[side], hits, shares_);
}

int HitSearch::searchLevels(const Query& query, HitColumns& hits) {
  ++work_.searches;
  for (Candidates& c : candidates_) c.all = true;
  for (int level = kLevels - 1;; --level) {
    hits.clear();
    searchSide(query, kA, level, hits);
    searchSide(query, kB, level, hits);
    work_.hits += hits.size();
    if (level == 0 || hits.size() >= neededOf(level, query.enough)) return level;
  }
}

int HitSearch::run(const ContactBody& a, const ContactBody& b, const PairFrame& frame,
                   double margin, std::size_t enough, HitColumns& hits, const TaskRunner* runner) {
  shares_.runner = runner;
  begin(margin > 0, hits);
  // Bullet's boxes exceed its bodies by 7 cm (gContactBreakingThreshold and the tree's margin),
  // whatever their size. In a box of small parts, most pairs are far apart.
  const double seen = marginOf(a, b, frame.voxel, margin);
  if (farApart(a, b, std::max(kFarApart * frame.voxel, seen))) return 0;
  const Query query = queryOf(a, b, frame, enough);
  const int level = searchLevels(query, hits);
  if (hits.empty() && margin > 0) touchLightly(query, frame, static_cast<float>(seen), hits);
  end();
  return level;
}

void HitSearch::runApart(const ContactBody& a, const ContactBody& b, const PairFrame& frame,
                         double margin, HitColumns& hits) {
  begin(false, hits);
  const auto seen = static_cast<float>(marginOf(a, b, frame.voxel, margin));
  touchLightly(queryOf(a, b, frame, 0), frame, seen, hits);
  end();
}

bool HitSearch::runBeside(const ContactBody& a, const ContactBody& b, const PairFrame& frame,
                          double margin, const KnownMeets& known, HitColumns& hits) {
  begin(false, hits);
  const auto seen = static_cast<float>(marginOf(a, b, frame.voxel, margin));
  touchLightly(queryOf(a, b, frame, 0), frame, seen, hits, &known);
  end();
  return !hits.empty();
}

// `wantsCoarse`: the search keeps what it finds at the coarsest samples.
void HitSearch::begin(bool wantsCoarse, HitColumns& hits) {
  for (int side = 0; side < 2; ++side) {
    coarse_[side].known = false;
    candidates_[side].coarse = wantsCoarse ? &coarse_[side] : nullptr;
    candidates_[side].work = {};
  }
  near_ = {};
  gap_ = 0;
  ends_.clear();
  hits.clear();
}

void HitSearch::end() {
  for (const Candidates& c : candidates_) work_ += c.work;
}

void HitSearch::reserveLike(const HitSearch& other) {
  for (int side = 0; side < 2; ++side) {
    candidates_[side].reserveLike(other.candidates_[side]);
    coarse_[side].reserveLike(other.coarse_[side]);
  }
  misses_.reserveLike(other.misses_);
  ends_.reserve(other.ends_.capacity());
  shares_.reserveLike(other.shares_);
}

// Turns near misses into hits; the nearest becomes kLightly deep.
void HitSearch::touchLightly(const Query& query, const PairFrame& frame, float margin,
                             HitColumns& hits, const KnownMeets* known) {
  const std::vector<NearMiss>& found =
      misses_.run(query.bodies, query.ways, frame, margin, coarse_, known);
  near_ = misses_.work();
  ++near_.searches;
  const float shift = NearMissSearch::kLightly * static_cast<float>(frame.voxel) -
                      static_cast<float>(misses_.nearest());
  const auto add = [&](bool all) {
    for (const Side side : {kA, kB})  // Binner expects A's hits first
      for (const NearMiss& miss : found) {
        if (miss.hit.side != side || miss.hit.depth + miss.spread + shift <= 0) continue;
        const Hit hit = movedIn(miss, shift);
        if (!(hit.depth1 > 0 && (all || faces(hit)))) continue;
        hits.push_back(hit);
        ends_.push_back(miss.hit.depth + miss.end + shift);
      }
  };
  add(false);
  if (hits.empty()) add(true);  // tips on one axis
  if (!hits.empty()) gap_ = static_cast<double>(shift);
  near_.hits = hits.size();
  work_ += near_;
}

}  // namespace cloudcontact
