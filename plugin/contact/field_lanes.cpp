// The loops over lanes: places, records, planes, kinds, hits. Only the lookup of records reads
// scattered memory, and the requests of all lanes run together there.
#include "contact/field_lanes.h"

#include "base/simd.h"

#include <algorithm>

namespace cloudcontact::search {

namespace {

// Makes a hit of a lane. It copies its inputs, so that the compiler knows that stores into the hits
// do not change them.
struct HitMaker {
  CcMap toFrame;
  float fromOwn[9], fromOther[9];
  float halfWidth;                                // [m] of a sample one voxel wide
  const float *x, *y, *z, *nx, *ny, *nz, *width;  // of the samples
  const std::uint32_t* sample;                    // of the lanes, and so on
  const float *depth, *mx, *my, *mz;

  HitMaker(const Direction& dir, const SampleColumns& s, const Lanes& l) : toFrame(dir.toFrame) {
    std::copy_n(dir.frameFromOwn, 9, fromOwn);
    std::copy_n(dir.frameFromOther, 9, fromOther);
    halfWidth = CC_HALF_WIDTH * dir.voxel;
    x = s.x.data(), y = s.y.data(), z = s.z.data();
    nx = s.nx.data(), ny = s.ny.data(), nz = s.nz.data();
    width = s.width.data();
    sample = l.sample;
    depth = l.depth;
    mx = l.nx, my = l.ny, mz = l.nz;
  }

  std::int32_t sampleOf(int lane) const { return static_cast<std::int32_t>(sample[lane]); }
  CcHit operator()(int lane) const {
    const std::int32_t k = sampleOf(lane);
    const float place[3] = {x[k], y[k], z[k]}, n[3] = {nx[k], ny[k], nz[k]};
    const float m[3] = {mx[lane], my[lane], mz[lane]};
    return ccHitIn(&toFrame, fromOwn, fromOther, place, n, m, depth[lane], halfWidth * width[k]);
  }
};

}  // namespace

CC_LANES void findRecords(const Direction& dir, const FieldData& other, Lanes& lanes) {
  const SampleColumns& samples = dir.samples.levels[dir.level].samples;
  const float* const px = samples.x.data();
  const float* const py = samples.y.data();
  const float* const pz = samples.z.data();
  const CcMap map = dir.toOther;
  const CcBricks bricks = other.records().bricks();
  const std::int32_t* const firsts = other.records().firsts();
  const CcVoxel* const records = other.records().records();
  const int count = padded(lanes.count);
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const std::int32_t k = static_cast<std::int32_t>(lanes.sample[i]);
    const float at[3] = {px[k], py[k], pz[k]};
    float x[3];
    ccApply(&map, at, x);
    const CcPlace place = ccPlaceOf(bricks, x);
    lanes.x[i] = place.r[0];
    lanes.y[i] = place.r[1];
    lanes.z[i] = place.r[2];
    lanes.record[i] = firsts[place.brick] + place.cell;
  }
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const CcVoxel v = records[lanes.record[i]];
    lanes.a[i] = v.a;
    lanes.b[i] = v.b;
  }
}

CC_LANES void findDepths(float voxel, Lanes& lanes) {
  const int count = padded(lanes.count);
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const float r[3] = {lanes.x[i], lanes.y[i], lanes.z[i]};
    const CcDepth d = ccPlaneDepth({lanes.a[i], lanes.b[i]}, r);
    lanes.depth[i] = d.depth * voxel;
    lanes.nx[i] = d.normal[0];
    lanes.ny[i] = d.normal[1];
    lanes.nz[i] = d.normal[2];
  }
}

CC_LANES void choosePlanes(const FieldData& other, float voxel, int wanted, Lanes& lanes) {
  if (wanted == 0) return;
  pad(lanes.several, wanted);
  const int count = padded(wanted);
  const CcVoxel* const planes = other.planes();
  std::uint32_t a[kLanes], b[kLanes];  // the records, then a plane of each
  float x[kLanes], y[kLanes], z[kLanes], size[kLanes], nx[kLanes], ny[kLanes], nz[kLanes];
  std::int32_t first[kLanes], has[kLanes], unites[kLanes], most = 0;
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const std::int32_t lane = lanes.several[i];
    const std::uint32_t record = lanes.a[lane];
    first[i] = static_cast<std::int32_t>(lanes.b[lane]);
    has[i] = static_cast<std::int32_t>(record >> 28 & 7u);
    unites[i] = static_cast<std::int32_t>(record >> 31);
    x[i] = lanes.x[lane];
    y[i] = lanes.y[lane];
    z[i] = lanes.z[lane];
    size[i] = 1e30f;  // least depth; of the negatives if planes unite
    nx[i] = ny[i] = nz[i] = 0;
  }
  for (int i = 0; i < count; ++i) most = std::max(most, has[i]);
  // One plane of every lane at a time. Lanes with fewer planes repeat their first.
  for (int k = 0; k < most; ++k) {
    CC_INDEPENDENT
    for (int i = 0; i < count; ++i) {
      const CcVoxel plane = planes[first[i] + (k < has[i] ? k : 0)];
      a[i] = plane.a;
      b[i] = plane.b;
    }
    CC_INDEPENDENT
    for (int i = 0; i < count; ++i) {
      const float r[3] = {x[i], y[i], z[i]};
      const CcDepth d = ccPlaneDepth({a[i], b[i]}, r);
      const float depth = unites[i] ? -d.depth : d.depth;
      const bool less = depth < size[i];
      nx[i] = less ? d.normal[0] : nx[i];
      ny[i] = less ? d.normal[1] : ny[i];
      nz[i] = less ? d.normal[2] : nz[i];
      size[i] = less ? depth : size[i];
    }
  }
  for (int i = 0; i < wanted; ++i) {
    const std::int32_t lane = lanes.several[i];
    lanes.depth[lane] = (unites[i] ? -size[i] : size[i]) * voxel;
    lanes.nx[lane] = nx[i];
    lanes.ny[lane] = ny[i];
    lanes.nz[lane] = nz[i];
  }
}

namespace {

// Moves to the front of lanes.several those that must be divided if they lie over an edge. Most
// need not.
CC_LANES int mayDivide(const Direction& dir, int count, Lanes& lanes) {
  const SampleColumns& samples = dir.samples.levels[dir.level].samples;
  const float* const sx = samples.nx.data();
  const float* const sy = samples.ny.data();
  const float* const sz = samples.nz.data();
  const float* const width = samples.width.data();
  const CcLimits limits = dir.limits();
  const float own = dir.voxel;
  float turn[9];
  for (int i = 0; i < 9; ++i) turn[i] = dir.turnToOther[i];
  pad(lanes.several, count);
  std::int32_t is[kLanes];
  const int all = padded(count);
  CC_INDEPENDENT
  for (int i = 0; i < all; ++i) {
    const std::int32_t lane = lanes.several[i];
    const std::int32_t k = static_cast<std::int32_t>(lanes.sample[lane]);
    const float n[3] = {sx[k], sy[k], sz[k]};
    const float m[3] = {lanes.nx[lane], lanes.ny[lane], lanes.nz[lane]};
    float other[3];
    ccTurnBack(turn, m, other);
    is[i] = ccMayDivide(&limits, {lanes.a[lane], lanes.b[lane]}, lanes.depth[lane], ccDot(n, other),
                        width[k], own);
  }
  int found = 0;
  for (int i = 0; i < count; ++i) {
    lanes.several[found] = lanes.several[i];
    found += is[i];
  }
  return found;
}

}  // namespace

CC_LANES int edgesWithin(const Direction& dir, const FieldData& other, float voxel, int wanted,
                         Lanes& lanes) {
  wanted = mayDivide(dir, wanted, lanes);
  if (wanted == 0) return 0;
  pad(lanes.several, wanted);
  const int count = padded(wanted);
  const float* const width = dir.samples.levels[dir.level].samples.width.data();
  const CcVoxel* const planes = other.planes();
  const float own = dir.voxel;
  float x[kLanes], y[kLanes], z[kLanes], nx[kLanes], ny[kLanes], nz[kLanes], depth[kLanes],
      far[kLanes];
  std::int32_t first[kLanes], has[kLanes], within[kLanes], most = 0;
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const std::int32_t lane = lanes.several[i];
    const std::uint32_t record = lanes.a[lane];
    first[i] = static_cast<std::int32_t>(lanes.b[lane]);
    has[i] = static_cast<std::int32_t>(record >> 28 & 7u);
    x[i] = lanes.x[lane], y[i] = lanes.y[lane], z[i] = lanes.z[lane];
    nx[i] = lanes.nx[lane], ny[i] = lanes.ny[lane], nz[i] = lanes.nz[lane];
    depth[i] = lanes.depth[lane];
    far[i] = CC_HALF_DIAGONAL * (width[static_cast<std::int32_t>(lanes.sample[lane])] * own);
    within[i] = 0;
  }
  for (int i = 0; i < count; ++i) most = std::max(most, has[i]);
  for (int k = 0; k < most; ++k) {
    CC_INDEPENDENT
    for (int i = 0; i < count; ++i) {
      const CcVoxel plane = planes[first[i] + (k < has[i] ? k : 0)];
      const float r[3] = {x[i], y[i], z[i]}, n[3] = {nx[i], ny[i], nz[i]};
      within[i] |= ccPlaneWithin(plane, r, depth[i], n, far[i], voxel);
    }
  }
  int found = 0;
  for (int i = 0; i < wanted; ++i) {
    lanes.several[found] = lanes.several[i];
    found += within[i];
  }
  return found;
}

int measure(const FieldData& other, float voxel, Lanes& lanes) {
  findDepths(voxel, lanes);
  int count = 0;
  for (int i = 0; i < lanes.count; ++i) {
    lanes.several[count] = i;
    count += (lanes.a[i] >> 28 & 7) > 1;
  }
  choosePlanes(other, voxel, count, lanes);
  return count;
}

namespace {

// What some lanes' samples stand for, one column for each number, because a loop that follows a
// pointer to each cluster does not become vector instructions.
struct Clusters {
  float spread[6][kLanes];

  CcCluster operator[](int i) const {
    return {0,
            {spread[0][i], spread[1][i], spread[2][i], spread[3][i], spread[4][i], spread[5][i]}};
  }
};

// Of the samples with these numbers.
CC_LANES void gather(const Direction& dir, const std::uint32_t* samples, int count, Clusters& to) {
  static_assert(sizeof(CcCluster) == 7 * sizeof(float));
  const float* const from = &dir.samples.levels[dir.level].clusters.data()->rise;
  for (int k = 0; k < 6; ++k) {
    float* const out = to.spread[k];
    CC_INDEPENDENT
    for (int i = 0; i < count; ++i)
      out[i] = from[7 * static_cast<std::int32_t>(samples[i]) + k + 1];
  }
}

}  // namespace

CC_LANES void findBeside(const Direction& dir, Lanes& lanes) {
  const CcLimits limits = dir.limits();
  const int count = padded(lanes.count);
  Clusters clusters;
  gather(dir, lanes.sample, count, clusters);
  float turn[9];
  for (int i = 0; i < 9; ++i) turn[i] = dir.turnToOther[i];
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const float m[3] = {lanes.nx[i], lanes.ny[i], lanes.nz[i]};
    const CcCluster cluster = clusters[i];
    lanes.beside[i] = ccDepthBeside(&limits, turn, &cluster, lanes.depth[i], m);
  }
}

CC_LANES void findBeside(const Direction& dir, const FieldData& other, float voxel, int wanted,
                         Lanes& lanes) {
  findBeside(dir, lanes);
  if (wanted == 0) return;
  pad(lanes.several, wanted);
  const int count = padded(wanted);
  const CcLimits limits = dir.limits();
  const CcVoxel* const planes = other.planes();
  float turn[9];
  for (int i = 0; i < 9; ++i) turn[i] = dir.turnToOther[i];
  std::uint32_t sample[kLanes] = {}, a[kLanes], b[kLanes];
  float x[kLanes], y[kLanes], z[kLanes], beside[kLanes];
  std::int32_t first[kLanes], has[kLanes], unites[kLanes], most = 0;
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const std::int32_t lane = lanes.several[i];
    const std::uint32_t record = lanes.a[lane];
    sample[i] = lanes.sample[lane];
    first[i] = static_cast<std::int32_t>(lanes.b[lane]);
    has[i] = static_cast<std::int32_t>(record >> 28 & 7u);
    unites[i] = static_cast<std::int32_t>(record >> 31);
    x[i] = lanes.x[lane], y[i] = lanes.y[lane], z[i] = lanes.z[lane];
    beside[i] = unites[i] ? -1e30f : 1e30f;
  }
  Clusters clusters;
  gather(dir, sample, count, clusters);
  for (int i = 0; i < count; ++i) most = std::max(most, has[i]);
  for (int k = 0; k < most; ++k) {
    CC_INDEPENDENT
    for (int i = 0; i < count; ++i) {
      const CcVoxel plane = planes[first[i] + (k < has[i] ? k : 0)];
      a[i] = plane.a;
      b[i] = plane.b;
    }
    CC_INDEPENDENT
    for (int i = 0; i < count; ++i) {
      const float r[3] = {x[i], y[i], z[i]};
      const CcDepth d = ccPlaneDepth({a[i], b[i]}, r);
      const CcCluster cluster = clusters[i];
      const float own = ccDepthBeside(&limits, turn, &cluster, d.depth * voxel, d.normal);
      const float more = ccMax(beside[i], own), less = ccMin(beside[i], own);
      beside[i] = unites[i] ? more : less;
    }
  }
  for (int i = 0; i < wanted; ++i) lanes.beside[lanes.several[i]] = beside[i];
}

namespace {

// Adds CC_NEARBY to the kinds of samples of a coarse level.
CC_LANES void markNearby(const Direction& dir, const CcLimits& limits, Lanes& lanes) {
  const CcCluster* const clusters = dir.samples.levels[dir.level].clusters.data();
  const int count = padded(lanes.count);
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const float rise = clusters[static_cast<std::int32_t>(lanes.sample[i])].rise;
    lanes.kind[i] |=
        ccNearBeside(&limits, {lanes.a[i], lanes.b[i]}, lanes.beside[i], rise) ? CC_NEARBY : 0;
  }
}

}  // namespace

CC_LANES void classify(const Direction& dir, bool finer, Lanes& lanes) {
  const SampleColumns& samples = dir.samples.levels[dir.level].samples;
  const float* const nx = samples.nx.data();
  const float* const ny = samples.ny.data();
  const float* const nz = samples.nz.data();
  const float* const width = samples.width.data();
  const int count = padded(lanes.count);
  const CcLimits limits = dir.limits();
  float turn[9];
  for (int i = 0; i < 9; ++i) turn[i] = dir.turnToOther[i];
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const std::int32_t k = static_cast<std::int32_t>(lanes.sample[i]);
    const float n[3] = {nx[k], ny[k], nz[k]}, m[3] = {lanes.nx[i], lanes.ny[i], lanes.nz[i]};
    float other[3];
    ccTurnBack(turn, m, other);
    const int kind = ccKindOf(&limits, {lanes.a[i], lanes.b[i]}, lanes.depth[i], width[k]);
    const int may = ccMayHit(&limits, lanes.depth[i], ccDot(n, other), width[k]);
    lanes.kind[i] = kind & (may ? ~0 : ~CC_WET);
  }
  if (finer && dir.level > 0) markNearby(dir, limits, lanes);
}

CC_LANES void estimateNearest(const Direction& dir, const Lanes& lanes, float* estimates) {
  const CcCluster* const clusters = dir.samples.levels[dir.level].clusters.data();
  const int count = lanes.count;
  const float voxel = dir.voxel;
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const float rise = clusters[static_cast<std::int32_t>(lanes.sample[i])].rise;
    const float near = voxel * (lanes.beside[i] + rise);
    // The records end two voxels outside.
    const float plain = lanes.b[i] == CC_NEAR_OUTSIDE ? -2.0f * voxel : -1e30f;
    estimates[i] = (lanes.a[i] & 0x70000000u) != 0 ? near : plain;
  }
}

CC_LANES bool addHits(const Direction& dir, const SampleColumns& samples, Lanes& lanes, int count,
                      HitColumns& hits) {
  if (count == 0) return true;
  pad(lanes.wet, count);
  const std::int32_t* const wet = lanes.wet;
  const HitMaker hitIn(dir, samples, lanes);
  const int made = padded(count);
  const HitColumns::Columns<float> to = hits.room(static_cast<std::size_t>(made));
  const float unit = dir.voxel * dir.voxel;
  const float* const area = samples.area.data();
  CC_INDEPENDENT
  for (int i = 0; i < made; ++i) {
    const CcHit h = hitIn(wet[i]);
    to.x[i] = h.position[0];
    to.y[i] = h.position[1];
    to.z[i] = h.position[2];
    to.ownX[i] = h.own[0];
    to.ownY[i] = h.own[1];
    to.ownZ[i] = h.own[2];
    to.otherX[i] = h.other[0];
    to.otherY[i] = h.other[1];
    to.otherZ[i] = h.other[2];
    to.area[i] = area[hitIn.sampleOf(wet[i])] * unit;
    to.share[i] = h.wet.share;
    to.depth1[i] = h.wet.depth1;
    to.depth2[i] = h.wet.depth2;
    to.depth3[i] = h.wet.depth3;
    to.depth[i] = hitIn.depth[wet[i]];
    to.facing[i] = h.facing;
  }
  std::int32_t none = 0;
  for (int i = 0; i < made; ++i) none |= !(to.depth1[i] > 0.0f);
  if (none) return false;
  hits.commit(static_cast<std::size_t>(count), dir.side, false);
  return true;
}

CC_LANES int hitsFirst(const Direction& dir, const SampleColumns& samples, Lanes& lanes,
                       int count) {
  if (count == 0) return 0;
  const HitMaker hitIn(dir, samples, lanes);
  float in[kLanes];
  pad(lanes.wet, count);
  const int tried = padded(count);
  CC_INDEPENDENT
  for (int i = 0; i < tried; ++i) in[i] = hitIn(lanes.wet[i]).wet.depth1;
  int some = 0;
  for (int i = 0; i < count; ++i) {
    lanes.wet[some] = lanes.wet[i];
    some += in[i] > 0.0f;
  }
  return some;
}

CC_LANES void nearBricks(const Direction& dir, const FieldData& other, float aside,
                         std::vector<std::uint32_t>& near) {
  const SampleBricks& from = dir.samples.bricks;
  const CcBricks bricks = other.records().bricks();
  const std::int32_t* const between = other.records().between();
  const CcMap map = dir.toOther;
  const float ratio = dir.voxel / static_cast<float>(other.cloud().voxelSize());
  const int all = static_cast<int>(from.runs.size());
  near.resize(from.runs.size());
  std::uint32_t* const out = near.data();
  std::size_t found = 0;
  for (int first = 0; first < all; first += kLanes) {
    const int count = std::min(kLanes, all - first);
    const float *const x = from.x.data() + first, *const y = from.y.data() + first,
                       *const z = from.z.data() + first, *const radius = from.radius.data() + first;
    std::int32_t touches[kLanes];
    CC_INDEPENDENT
    for (int i = 0; i < count; ++i) {
      const float c[3] = {x[i], y[i], z[i]};
      touches[i] = ccBrickTouches(&map, c, radius[i] + aside, ratio, bricks, between);
    }
    for (int i = 0; i < count; ++i) {
      out[found] = static_cast<std::uint32_t>(first + i);
      found += static_cast<std::size_t>(touches[i]);
    }
  }
  near.resize(found);
}

}  // namespace cloudcontact::search
