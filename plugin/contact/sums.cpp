// Sums of hits, four numbers at a time (kernels/hit_sums.h). In double, which costs no more than
// float here, and in lengths of the hits' own size.
#include "sums.h"

#include "simd.h"

#include <cstddef>
#include <cstring>

namespace cloudcontact {

namespace {

CcAdded added(const CcAdding& from) {
  CcAdded sums;
  static_assert(offsetof(CcAdding, middle) == CC_ADDED_FOURS * sizeof(CcFour));
  std::memcpy(&sums, &from, CC_ADDED_FOURS * sizeof(CcFour));
  sums.middle = from.middle;
  sums.deepest = static_cast<double>(from.deepest);
  return sums;
}

}  // namespace

CC_LANES void addHits(const HitColumns& hits, const float* gate, const HitRun& run, double unit) {
  const HitColumns::Columns<const float> c = hits.columns();
  const double perUnit = 1 / unit;
  CcAdding adding = ccNothingAdded();
  for (const std::uint32_t* hit = run.first; hit != run.last; ++hit) {
    const std::size_t i = *hit;
    const float at[3] = {c.x[i], c.y[i], c.z[i]}, own[3] = {c.ownX[i], c.ownY[i], c.ownZ[i]},
                other[3] = {c.otherX[i], c.otherY[i], c.otherZ[i]};
    const CcWet wet{c.share[i], 0, c.depth1[i], c.depth2[i], c.depth3[i]};
    ccAddHit(&adding, at, own, other, c.area[i], &wet, c.depth[i], gate[i], run.to->origin.data(),
             perUnit, 1);
  }
  const CcAdded all = added(adding);
  ccGive(reinterpret_cast<CcSums*>(run.to), &all, static_cast<int>(run.last - run.first), 1,
         run.side, unit);
}

void addDeep(const HitColumns& hits, const HitRun& run) {
  const HitColumns::Columns<const float> c = hits.columns();
  for (const std::uint32_t* hit = run.first; hit != run.last; ++hit)
    if (hits.deep(*hit)) run.to->deep += static_cast<double>(c.area[*hit]) * c.depth1[*hit];
}

namespace {

// Eight runs of hits side by side; a lane that has come to its end takes the next run.
struct RunLanes {
  double sums[CC_LANE_SUMS][CC_SUM_LANES] = {};
  double origin[3][CC_SUM_LANES] = {}, live[CC_SUM_LANES] = {};
  float deepest[CC_SUM_LANES] = {};
  std::int32_t hit[CC_SUM_LANES] = {};
  const HitRun* run[CC_SUM_LANES] = {};
  const std::uint32_t* next[CC_SUM_LANES] = {};

  void begin(int lane, const HitRun* from) {
    run[lane] = from;
    live[lane] = from ? 1 : 0;
    if (!from) return;
    next[lane] = from->first;
    hit[lane] = static_cast<std::int32_t>(*from->first);
    deepest[lane] = -1e30f;
    for (int i = 0; i < 3; ++i) origin[i][lane] = from->to->origin[i];
  }
  void end(int lane, double unit) {
    const HitRun& from = *run[lane];
    const CcAdded all = ccTakeLane(sums, lane, static_cast<double>(deepest[lane]));
    ccGive(reinterpret_cast<CcSums*>(from.to), &all, static_cast<int>(from.last - from.first), 0,
           from.side, unit);
  }
};

// One hit of each lane; a lane without a run adds nothing.
CC_LANES void addStep(const HitColumns::Columns<const float>& columns, const float* gate,
                      double perUnit, RunLanes& lanes) {
  const HitColumns::Columns<const float> c = columns;
  CC_INDEPENDENT
  for (int l = 0; l < CC_SUM_LANES; ++l) {
    const std::int32_t i = lanes.hit[l];
    const float at[3] = {c.x[i], c.y[i], c.z[i]}, own[3] = {c.ownX[i], c.ownY[i], c.ownZ[i]},
                other[3] = {c.otherX[i], c.otherY[i], c.otherZ[i]};
    const double origin[3] = {lanes.origin[0][l], lanes.origin[1][l], lanes.origin[2][l]};
    const CcWet wet{c.share[i], 0, c.depth1[i], c.depth2[i], c.depth3[i]};
    const CcWeights h = ccWeightsOf(at, c.area[i], &wet, gate[i], origin, perUnit);
    const double live = lanes.live[l];
    const CcWeights counted{
        h.whole * live,   h.pressed * live,        h.w * live, h.f * live, h.blind * live,
        h.weighed * live, {h.x[0], h.x[1], h.x[2]}};
    ccAddInLane(lanes.sums, l, &counted, own, other, &wet, c.depth[i], perUnit);
    lanes.deepest[l] = ccMax(lanes.deepest[l], c.depth[i]);
  }
}

}  // namespace

void addRuns(const HitColumns& hits, const float* gate, std::span<const HitRun> runs, double unit) {
  RunLanes lanes;
  const HitColumns::Columns<const float> columns = hits.columns();
  const HitRun *next = runs.data(), *const end = next + runs.size();
  int live = 0;
  for (int l = 0; l < CC_SUM_LANES; ++l) {
    live += next != end;
    lanes.begin(l, next != end ? next++ : nullptr);
  }
  while (live > 0) {
    addStep(columns, gate, 1 / unit, lanes);
    for (int l = 0; l < CC_SUM_LANES; ++l) {
      if (!lanes.run[l]) continue;
      if (++lanes.next[l] != lanes.run[l]->last) {
        lanes.hit[l] = static_cast<std::int32_t>(*lanes.next[l]);
        continue;
      }
      lanes.end(l, unit);
      live -= next == end;
      lanes.begin(l, next != end ? next++ : nullptr);
    }
  }
}

void Sums::add(const Sums& other) {
  ccJoinSums(reinterpret_cast<CcSums*>(this), reinterpret_cast<const CcSums*>(&other));
}

}  // namespace cloudcontact
