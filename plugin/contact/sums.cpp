// Sums of hits in double, which costs no more than float here, with lengths in units of the bin's
// size.
#include "contact/sums.h"

#include "base/simd.h"

#include <cstddef>
#include <cstring>

namespace cloudcontact {

namespace {

// Clears all but the origin.
void clear(CcSums& sums) {
  static_assert(offsetof(CcSums, side) == sizeof sums.origin);
  std::memset(sums.side, 0, sizeof sums - sizeof sums.origin);
  sums.deepest = -1e300;
}

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
  if (run.begins) clear(*run.to);
  CcAdding adding = ccNothingAdded();
  for (const std::uint32_t* hit = run.first; hit != run.last; ++hit) {
    const std::size_t i = *hit;
    const float at[3] = {c.x[i], c.y[i], c.z[i]}, own[3] = {c.ownX[i], c.ownY[i], c.ownZ[i]},
                other[3] = {c.otherX[i], c.otherY[i], c.otherZ[i]};
    const CcWet wet{c.share[i], 0, c.depth1[i], c.depth2[i], c.depth3[i]};
    ccAddHit(&adding, at, own, other, c.area[i], &wet, c.depth[i], gate[i], run.to->origin, perUnit,
             1);
  }
  const CcAdded all = added(adding);
  ccGive(run.to, &all, static_cast<int>(run.last - run.first), 1, run.side, unit);
}

void addDeep(const HitColumns& hits, const HitRun& run) {
  const HitColumns::Columns<const float> c = hits.columns();
  for (const std::uint32_t* hit = run.first; hit != run.last; ++hit)
    if (hits.deep(*hit)) run.to->deep += static_cast<double>(c.area[*hit]) * c.depth1[*hit];
}

namespace {

// Eight runs of hits side by side. A lane at the end of its run takes the next run.
struct RunLanes {
  CcEight sums[CC_LANE_SUMS] = {};
  CcEight origin[3] = {}, deepest = {};
  CcEightBits keep = {};
  std::int32_t hit[CC_SUM_LANES] = {};
  const HitRun* run[CC_SUM_LANES] = {};
  const std::uint32_t* next[CC_SUM_LANES] = {};

  void begin(int lane, const HitRun* from) {
    run[lane] = from;
    keep[lane] = 0;
    if (!from) return;  // the lane's sums are not used from here on
    if (from->begins) clear(*from->to);
    next[lane] = from->first;
    hit[lane] = static_cast<std::int32_t>(*from->first);
    deepest[lane] = -1e30;
    for (int i = 0; i < 3; ++i) origin[i][lane] = from->to->origin[i];
  }
  void end(int lane, double unit) {
    const HitRun& from = *run[lane];
    const CcAdded all = ccTakeLane(sums, lane, deepest[lane]);
    ccGive(from.to, &all, static_cast<int>(from.last - from.first), 0, from.side, unit);
  }
};

typedef float EightFloats __attribute__((vector_size(32)));

// Reads eight hits' values of one column.
[[gnu::always_inline]] inline void take(const float* column, const std::int32_t* hit, CcEight& to) {
  const EightFloats v = {column[hit[0]], column[hit[1]], column[hit[2]], column[hit[3]],
                         column[hit[4]], column[hit[5]], column[hit[6]], column[hit[7]]};
  to = __builtin_convertvector(v, CcEight);
}

// Adds one hit in each lane.
CC_LANES void addStep(const HitColumns::Columns<const float>& columns, const float* gate,
                      double perUnit, RunLanes& lanes) {
  const HitColumns::Columns<const float> c = columns;
  const std::int32_t* const hit = lanes.hit;
  CcEightHits h;
  const float *const at[3] = {c.x, c.y, c.z}, *const own[3] = {c.ownX, c.ownY, c.ownZ},
                     *const other[3] = {c.otherX, c.otherY, c.otherZ};
  for (int i = 0; i < 3; ++i) {
    take(at[i], hit, h.x[i]);
    h.x[i] = (h.x[i] - lanes.origin[i]) * perUnit;
    take(own[i], hit, h.own[i]);
    take(other[i], hit, h.other[i]);
  }
  take(c.area, hit, h.area);
  take(c.share, hit, h.share);
  take(c.depth1, hit, h.depth1);
  take(c.depth2, hit, h.depth2);
  take(c.depth3, hit, h.depth3);
  take(c.depth, hit, h.depth);
  take(gate, hit, h.gate);
  ccAddInLanes(lanes.sums, &h, &lanes.keep, perUnit);
  lanes.deepest = lanes.deepest > h.depth ? lanes.deepest : h.depth;
  lanes.keep = ~CcEightBits{};
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

CcVec centerOf(const CcSums& sums) {
  const CcVec origin = ccVecAt(sums.origin);
  if (!(sums.area > 0)) return origin;
  return ccPlus(origin, ccVec(sums.first[0] / sums.area, sums.first[1] / sums.area,
                              sums.first[2] / sums.area));
}

}  // namespace cloudcontact
