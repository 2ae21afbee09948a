// Level by level, the best estimates first.
#include "contact/near_misses.h"

#include "contact/search_targets.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace cloudcontact {

using namespace search;

namespace {

// Coarse samples whose cells are searched on, on each level: so many by their estimates, and as
// many others by their own depths.
constexpr std::size_t kBest = 64;
// [voxels] As kLightly, of depths at the step's end. With 0.1, not the edge that comes down was
// found but the middle of the face, which is nearer and comes down by less.
constexpr float kAhead = 0.025f;
constexpr float kNone = -1e30f;  // less than any depth [m]

}  // namespace

// One body's samples on their way into the other.
struct NearMissSearch::OneSide {
  const ContactBody *own, *other;
  const CcWay& way;
  Side side;

  Direction at(int level) const {
    const FieldData& samples = own->field->data();
    return {way,   samples, samples.samples(),
            level, side,    static_cast<float>(samples.cloud().voxelSize())};
  }
  const FieldData* field() const { return other->shape ? nullptr : &other->field->data(); }
  template <typename Visit>
  void withTarget(const Direction& dir, Visit&& visit) const {
    if (const FieldData* const to = field())
      return visit(FieldTarget{dir, *to, static_cast<float>(to->cloud().voxelSize())});
    const Pose toShape = toShapeOf(*own, *other);
    visit(ShapeTarget{dir, *other->shape, toShape, dir.samples.levels[dir.level].samples});
  }
};

NearMissSearch::NearMissSearch() : lanes_(std::make_unique<Lanes>()) {}
NearMissSearch::~NearMissSearch() = default;

void NearMissSearch::reserveLike(const NearMissSearch& other) {
  now_.reserve(other.now_.capacity());
  next_.reserve(other.next_.capacity());
  coarsest_.reserve(other.coarsest_.capacity());
  for (int level = 0; level < kLevels; ++level)
    others_[level].reserve(other.others_[level].capacity());
  bricks_.reserve(other.bricks_.capacity());
  runs_.reserve(other.runs_.capacity());
  for (int side = 0; side < 2; ++side) near_[side].reserve(other.near_[side].capacity());
  found_.reserve(other.found_.capacity());
  ranks_.reserve(other.ranks_.capacity());
}

// Looks up the samples of these runs.
template <typename Target>
void NearMissSearch::look(const Direction& dir, const Target& target, const SampleRun* first,
                          const SampleRun* last) {
  Lanes& lanes = *lanes_;
  lanes.clear();
  const auto flush = [&] {
    if (lanes.count == 0) return;
    work_.samples += static_cast<std::size_t>(lanes.count);
    loadSamples(dir, true, lanes);
    target.measurePoints(lanes);
    work_.planes += std::exchange(lanes.planes, 0);
    if (known_ || dir.level == 0 || takingOthers_) findFacing(dir, lanes);
    take(dir, target.field());
    lanes.clear();
  };
  for (; first != last; ++first)
    for (SampleRun run = *first; run.count > 0;) {
      if (lanes.full()) flush();
      const std::uint32_t some = lanes.add(run);
      run.first += some;
      run.count -= some;
    }
  flush();
}

// The other's normal at a lane's sample, as the samples' grid sees it.
V3 normalThere(const Direction& dir, const Lanes& lanes, int lane) {
  const float normal[3] = {lanes.nx[lane], lanes.ny[lane], lanes.nz[lane]};
  V3 there;
  ccTurnBack(dir.turnToOther, normal, there.data());
  return there;
}

// How much deeper a sample gets within the step [m], if that counts: against the other's normal
// there, since what slides along a surface comes no nearer to it. The less of two ways: on a line,
// a ball's front seems to come down where it rolls; on an arc, a nut's flank seems to enter the
// bolt about which it turns, since the normal does not turn with it.
float NearMissSearch::wayOf(int side, const V3& place, const V3& there) const {
  if (!looks(KnownMeets::Look::Ahead)) return 0;
  const auto way = [&](const KnownMeets::Way& by) {
    return -(by.turn * place + by.shift).dot(there);
  };
  return std::min(way(known_->of[side].arc), way(known_->of[side].line));
}

float NearMissSearch::wayOf(const Direction& dir, int lane) const {
  const LaneSamples& own = lanes_->own;
  return wayOf(dir.side, {own.x[lane], own.y[lane], own.z[lane]}, normalThere(dir, *lanes_, lane));
}

// Whether a sample that faces the other surface counts beside a touch. `depth` [m]: at the step's
// end.
bool NearMissSearch::isBeside(int side, const V3& place, const V3& normal, float depth) const {
  const KnownMeets::Look look = known_->look;
  if (look == KnownMeets::Look::Ahead && depth <= 0) return false;
  const float within = look == KnownMeets::Look::Far ? kFarPlace : kSamePlace;
  bool same = false;
  for (const KnownMeets::Meet& meet : known_->of[side].meets) {
    if (normal.dot(meet.normal) <= kSameWay) continue;
    if (look == KnownMeets::Look::Beside) return false;
    if (meet.apartFrom(place) < within * within) return false;
    same = true;
  }
  return same || look != KnownMeets::Look::Far;
}

bool NearMissSearch::isBeside(const Direction& dir, int lane, float depth) const {
  if (lanes_->facing[lane] > -kFacing) return false;
  const LaneSamples& own = lanes_->own;
  return isBeside(dir.side, {own.x[lane], own.y[lane], own.z[lane]},
                  {own.nx[lane], own.ny[lane], own.nz[lane]}, depth);
}

// Keeps the candidates among some coarse samples. Most vectors of them hold none.
template <typename Sample>
void NearMissSearch::consider(const Direction& dir, const float* estimates, const float* depths,
                              int count, const Sample& sample) {
  const auto wanted = [&](int i) { return isWanted(estimates[i], depths[i]); };
  for (int first = 0; first < count; first += kVector) {
    const int last = std::min(first + kVector, count);
    int any = 0;
    for (int i = first; i < last; ++i) any |= wanted(i);
    if (!any) continue;
    for (int i = first; i < last; ++i)
      if (wanted(i) && (!known_ || isBeside(dir, i, estimates[i])))
        next_.push_back({estimates[i], depths[i], sample(i), static_cast<std::int8_t>(dir.side)});
    if (next_.size() > 8 * kBest) keepBest();
  }
}

// Keeps what the lanes found: candidates, or samples of the finest level.
void NearMissSearch::take(const Direction& dir, const FieldData* other) {
  const Lanes& lanes = *lanes_;
  if (dir.level > 0 && !takingOthers_) {
    float estimates[kLanes], depths[kLanes];
    estimateNearest(dir, lanes, estimates, depths);
    if (known_ && dir.level == kLevels - 1) return takeCoarsest(dir, estimates, depths);
    // A cell whose middle touches is left out: such cells are many, and are no near misses.
    for (int i = 0; known_ && i < lanes.count; ++i) {
      const bool none = estimates[i] < -margin_ || depths[i] >= 0;
      const float way = none ? kNone : wayOf(dir, i);
      estimates[i] += way;
      depths[i] += way;
    }
    if (!known_) keepOthers(dir, depths, lanes.count, lanes.sample, 0);
    consider(dir, estimates, depths, lanes.count, [&](int i) { return lanes.sample[i]; });
    return;
  }
  keepNear(dir, other);
}

// Keeps the lanes that may count. By the step's end the bodies have turned: how far a sample
// reaches now says nothing of then.
void NearMissSearch::keepNear(const Direction& dir, const FieldData* other) {
  const Lanes& lanes = *lanes_;
  const bool ahead = looks(KnownMeets::Look::Ahead);
  float most[kLanes];
  std::int32_t near[kLanes], list[kLanes];
  findMost(lanes, ahead ? 0 : dir.limits().halfWidth, margin_, ahead ? kNone : nearest_ - within_,
           most, near);
  const int found = listSet<std::int32_t>(near, 1, lanes.count, nullptr, list);
  std::vector<Near>& kept = near_[dir.side];
  const std::size_t before = kept.size();
  for (int n = 0; n < found; ++n) {
    const int i = list[n];
    const float depth = lanes.depth[i], way = wayOf(dir, i);
    if (most[i] + way < nearest_ - within_) continue;
    if (known_ && (depth >= 0 || !isBeside(dir, i, depth + way))) continue;
    kept.push_back(
        {most[i] + way, way, lanes.sample[i], depth, {lanes.nx[i], lanes.ny[i], lanes.nz[i]}});
  }
  if (!takingOthers_) findNearest(dir, other, before);
}

// The nearest so far, by the few of the last lanes that may be nearest. Most others need not be
// kept then; what is found does not depend on how many are tried.
void NearMissSearch::findNearest(const Direction& dir, const FieldData* other, std::size_t from) {
  constexpr int kMostTries = 4;
  const std::vector<Near>& kept = near_[dir.side];
  float below = -kNone;
  for (int tries = 0; tries < kMostTries; ++tries) {
    const Near* best = nullptr;
    for (std::size_t i = from; i < kept.size(); ++i)
      if (kept[i].most < below && (!best || kept[i].most > best->most)) best = &kept[i];
    if (!best || best->most <= nearest_) return;
    below = best->most;
    if (const auto miss = weighed(dir, other, *best)) {
      nearest_ = std::max(nearest_, miss->hit.depth + best->way);
      return;
    }
  }
}

std::optional<NearMiss> NearMissSearch::weighed(const Direction& dir, const FieldData* other,
                                                const Near& n) {
  std::optional<NearMiss> miss = missOf(dir, other, dir.samples.levels[dir.level].samples[n.sample],
                                        {n.depth, n.other}, work_.samples);
  if (looks(KnownMeets::Look::Apart) && miss && miss->hit.depth + miss->end >= 0) miss.reset();
  return miss;
}

// Samples that will be in the other body, in part at least, once the nearest is kLightly deep.
void NearMissSearch::takeMisses(const OneSide& side, int level) {
  if (near_[side.side].empty()) return;
  const Direction dir = side.at(level);
  const bool ahead = looks(KnownMeets::Look::Ahead);
  for (const Near& n : near_[side.side]) {
    if (n.most < nearest_ - within_) continue;
    const std::optional<NearMiss> miss = weighed(dir, side.field(), n);
    if (!miss) continue;
    const float rank = miss->hit.depth + n.way;
    if (!takingOthers_) nearest_ = std::max(nearest_, rank);
    found_.push_back(*miss);
    ranks_.push_back(rank + (ahead ? 0 : miss->spread));
  }
  near_[side.side].clear();
}

// Keeps what may count in this search beside a touch or in one that follows.
void NearMissSearch::takeCoarsest(const Direction& dir, const float* estimates,
                                  const float* depths) {
  const Lanes& lanes = *lanes_;
  const LaneSamples& own = lanes.own;
  for (int i = 0; i < lanes.count; ++i)
    if (estimates[i] >= -margin_ && depths[i] < 0 && lanes.facing[i] <= -kFacing)
      coarsest_.push_back(
          {{estimates[i], depths[i], lanes.sample[i], static_cast<std::int8_t>(dir.side)},
           {own.x[i], own.y[i], own.z[i]},
           {own.nx[i], own.ny[i], own.nz[i]},
           normalThere(dir, lanes, i)});
}

void NearMissSearch::considerCoarsest() {
  for (const Coarsest& c : coarsest_) {
    const float way = wayOf(c.side, c.place, c.there);
    const Candidate at = {c.estimate + way, c.depth + way, c.sample, c.side};
    if (!isWanted(at.estimate, at.depth) || !isBeside(c.side, c.place, c.normal, at.estimate))
      continue;
    next_.push_back(at);
    if (next_.size() > 8 * kBest) keepBest();
  }
}

// Remembers coarse samples that are about as near as the nearest so far. `samples`: their numbers;
// null: from `first` on.
void NearMissSearch::keepOthers(const Direction& dir, const float* depths, int count,
                                const std::uint32_t* samples, std::uint32_t first) {
  std::vector<Other>& others = others_[dir.level];
  for (int i = 0; i < count; ++i) {
    if (!(depths[i] >= othersFrom_)) continue;
    othersFrom_ = std::max(othersFrom_, depths[i] - within_);
    others.push_back({depths[i], samples ? samples[i] : first + static_cast<std::uint32_t>(i),
                      static_cast<std::int8_t>(dir.side)});
  }
}

// Leaves only those of a level whose cells are not searched on.
void NearMissSearch::leaveOutSearchedOn(const OneSide& side, int level) {
  if (!side.own->field) return;
  const LargeVector<std::uint32_t>& cellOf = side.own->field->data().samples().levels[level].cellOf;
  std::vector<std::uint32_t>& cells = bricks_;
  cells.clear();
  for (const Candidate& c : now_)
    if (c.side == side.side) cells.push_back(cellOf[c.sample]);
  std::sort(cells.begin(), cells.end());
  std::erase_if(others_[level], [&](const Other& o) {
    return o.side == side.side && std::binary_search(cells.begin(), cells.end(), cellOf[o.sample]);
  });
}

// Looks the others of a level up again, as near misses.
void NearMissSearch::takeOthers(const OneSide& side, int level) {
  if (!side.own->field || others_[level].empty()) return;
  const Direction dir = side.at(level);
  runs_.clear();
  for (const Other& o : others_[level])
    if (o.side == side.side && o.depth >= nearest_ - within_) runs_.push_back({o.sample, 1});
  std::sort(runs_.begin(), runs_.end(),
            [](const SampleRun& a, const SampleRun& b) { return a.first < b.first; });
  takingOthers_ = true;
  side.withTarget(dir, [&](const auto& target) {
    look(dir, target, runs_.data(), runs_.data() + runs_.size());
  });
  takeMisses(side, level);
  takingOthers_ = false;
}

// Moves the best by a member, kBest of them, to the places after `from`. No two candidates are
// equal, so that it is the same on every machine.
void NearMissSearch::keepFirst(std::size_t from, float Candidate::*by) {
  const auto begin = next_.begin() + static_cast<std::ptrdiff_t>(from);
  std::nth_element(begin, begin + kBest - 1, next_.end(),
                   [by](const Candidate& a, const Candidate& b) {
                     if (a.*by != b.*by) return a.*by > b.*by;
                     return a.side != b.side ? a.side < b.side : a.sample < b.sample;
                   });
}

// Of the candidates, the best ones; none that is worse will be needed.
void NearMissSearch::keepBest() {
  if (next_.size() <= 2 * kBest) return;
  keepFirst(0, &Candidate::estimate);
  leastEstimate_ = next_[kBest - 1].estimate;
  keepFirst(kBest, &Candidate::depth);
  leastDepth_ = next_[2 * kBest - 1].depth;
  next_.erase(next_.begin() + 2 * kBest, next_.end());
}

// All samples of the coarsest level, in bricks that are near enough. What the search for touches
// has looked up is known.
void NearMissSearch::scan(const OneSide& side, const CoarseFound& coarse) {
  if (!side.own->field) return;
  const Direction dir = side.at(kLevels - 1);
  side.withTarget(dir, [&](const auto& target) {
    target.nearBricks(margin_ / dir.voxel, bricks_);
    work_.bricks += dir.samples.bricks.runs.size();
    runs_.clear();
    auto known = coarse.bricks.begin();
    const auto end = coarse.known && !known_ ? coarse.bricks.end() : known;
    for (const std::uint32_t b : bricks_) {
      const SampleRun run = dir.samples.bricks.runs[b];
      while (known != end && *known < b) ++known;
      if (known == end || *known != b) {
        runs_.push_back(run);
        continue;
      }
      keepOthers(dir, coarse.depth.data() + run.first, static_cast<int>(run.count), nullptr,
                 run.first);
      consider(dir, coarse.estimate.data() + run.first, coarse.depth.data() + run.first,
               static_cast<int>(run.count),
               [&](int i) { return run.first + static_cast<std::uint32_t>(i); });
    }
    look(dir, target, runs_.data(), runs_.data() + runs_.size());
  });
}

// The samples on `level` of the candidates' cells.
void NearMissSearch::searchOn(const OneSide& side, int level) {
  if (!side.own->field) return;
  const Direction dir = side.at(level);
  const SampleLevel& coarser = dir.samples.levels[level + 1];
  runs_.clear();
  std::uint32_t last = ~0u;
  for (const Candidate& c : now_) {
    if (c.side != side.side) continue;
    const std::uint32_t cell = coarser.cellOf[c.sample];
    if (cell != last) runs_.push_back(coarser.finer[cell]);
    last = cell;
  }
  side.withTarget(dir, [&](const auto& target) {
    look(dir, target, runs_.data(), runs_.data() + runs_.size());
  });
}

void NearMissSearch::keepNearest() {
  std::size_t kept = 0;
  float nearest = kNone;
  for (std::size_t i = 0; i < found_.size(); ++i) {
    if (ranks_[i] < nearest_ - within_) continue;
    nearest = std::max(nearest, found_[i].hit.depth);
    found_[kept++] = found_[i];
  }
  found_.resize(kept);
  nearest_ = nearest;
}

const std::vector<NearMiss>& NearMissSearch::run(const ContactBody* const* bodies,
                                                 const CcWay* ways, const PairFrame& frame,
                                                 float margin, const CoarseFound* coarse,
                                                 const KnownMeets* known) {
  known_ = known;
  margin_ = margin;
  least_ = known ? kNone / 2 : -margin;
  within_ = (known && known->look == KnownMeets::Look::Ahead ? kAhead : kLightly) *
            static_cast<float>(frame.voxel);
  nearest_ = kNone;
  work_ = {};
  for (std::vector<Near>& near : near_) near.clear();
  found_.clear();
  ranks_.clear();
  const OneSide sides[2] = {{bodies[0], bodies[1], ways[0], kA},
                            {bodies[1], bodies[0], ways[1], kB}};
  const auto begin = [&] {
    next_.clear();
    leastEstimate_ = leastDepth_ = least_;
  };
  begin();
  for (std::vector<Other>& others : others_) others.clear();
  othersFrom_ = -margin;
  if (!known || !known->again) {
    coarsest_.clear();
    for (const OneSide& side : sides) scan(side, coarse[side.side]);
  }
  if (known) considerCoarsest();
  for (int level = kLevels - 2; level >= 0; --level) {
    keepBest();
    std::swap(now_, next_);
    // In the samples' order, which is that of cells and of memory.
    std::sort(now_.begin(), now_.end(), [](const Candidate& a, const Candidate& b) {
      return a.side != b.side ? a.side < b.side : a.sample < b.sample;
    });
    begin();
    for (const OneSide& side : sides) {
      if (!known) leaveOutSearchedOn(side, level + 1);
      searchOn(side, level);
    }
  }
  for (const OneSide& side : sides) takeMisses(side, 0);
  if (!known)
    for (int level = kLevels - 1; level > 0; --level)
      for (const OneSide& side : sides) takeOthers(side, level);
  keepNearest();
  return found_;
}

}  // namespace cloudcontact
