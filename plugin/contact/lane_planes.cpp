// Lanes whose records have several planes: a third of them on a thread. They are copied together,
// those with the most planes first, and one plane of each is read at a time.
#include "contact/field_lanes.h"

#include "base/simd.h"

#include <algorithm>

namespace cloudcontact::search {

namespace {

// The planes of some lanes. Every lane has a first plane; the last vector repeats it where a lane
// has no other.
struct PlaneLanes {
  int count = 0;
  int having[CC_MAX_PLANES + 1] = {};  // lanes with more than k planes: they are the first ones
  std::int32_t lane[kLanes + 1];       // sorting writes one too many
  std::int32_t first[kLanes], unites[kLanes];
  float x[kLanes], y[kLanes], z[kLanes];
  CcVoxel plane[kLanes];

  void sort(const Lanes& lanes, const std::int32_t* list, int listed);
  void read(const CcVoxel* planes, int k);
};

// A pass for each number of planes that occurs, mostly two: a counting sort waits for its counts.
void PlaneLanes::sort(const Lanes& lanes, const std::int32_t* list, int listed) {
  std::int32_t planes[kLanes];
  std::uint32_t occurs = 0;
  for (int i = 0; i < listed; ++i) {
    planes[i] = static_cast<std::int32_t>(lanes.a[list[i]] >> 28 & 7u);
    occurs |= 1u << planes[i];
  }
  count = 0;
  for (int k = CC_MAX_PLANES; k > 0; --k) {
    for (int i = 0; (occurs >> k & 1u) && i < listed; ++i) {
      lane[count] = list[i];
      count += planes[i] == k;
    }
    having[k - 1] = count;
  }
  pad(lane, count);
  for (int i = 0; i < padded(count); ++i) {
    const std::int32_t l = lane[i];
    first[i] = static_cast<std::int32_t>(lanes.b[l]);
    unites[i] = static_cast<std::int32_t>(lanes.a[l] >> 31);
    x[i] = lanes.x[l], y[i] = lanes.y[l], z[i] = lanes.z[l];
  }
}

// The k-th planes of those that have so many.
void PlaneLanes::read(const CcVoxel* planes, int k) {
  for (int i = 0; i < having[k]; ++i) plane[i] = planes[first[i] + k];
  for (int i = having[k]; i < padded(having[k]); ++i) plane[i] = planes[first[i]];
}

// The plane that gives each lane's depth.
struct Deepest {
  float size[kLanes];  // least depth; of the negatives if planes unite
  float nx[kLanes], ny[kLanes], nz[kLanes];

  void begin(int count) {
    std::fill_n(size, count, 1e30f);
    std::fill_n(nx, count, 0.0f), std::fill_n(ny, count, 0.0f), std::fill_n(nz, count, 0.0f);
  }
};

// What the samples of these lanes stand for, and the bound over their planes so far.
struct BesideLanes {
  float spread[6][kLanes], beside[kLanes];

  void begin(const PlaneLanes& planes, const Lanes& lanes) {
    for (int k = 0; k < 6; ++k)
      for (int i = 0; i < padded(planes.count); ++i)
        spread[k][i] = lanes.own.spread[k][planes.lane[i]];
    for (int i = 0; i < padded(planes.count); ++i) beside[i] = planes.unites[i] ? -1e30f : 1e30f;
  }
};

CC_LANES void takePlane(const PlaneLanes& planes, int count, Deepest& best) {
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const float r[3] = {planes.x[i], planes.y[i], planes.z[i]};
    const CcDepth d = ccPlaneDepth(planes.plane[i], r);
    const float depth = planes.unites[i] ? -d.depth : d.depth;
    const bool less = depth < best.size[i];
    best.nx[i] = less ? d.normal[0] : best.nx[i];
    best.ny[i] = less ? d.normal[1] : best.ny[i];
    best.nz[i] = less ? d.normal[2] : best.nz[i];
    best.size[i] = less ? depth : best.size[i];
  }
}

CC_LANES void boundPlane(const Direction& dir, const PlaneLanes& planes, float voxel, int count,
                         BesideLanes& bound) {
  const CcLimits limits = dir.limits();
  float turn[9];
  for (int i = 0; i < 9; ++i) turn[i] = dir.turnToOther[i];
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const float r[3] = {planes.x[i], planes.y[i], planes.z[i]};
    const CcDepth d = ccPlaneDepth(planes.plane[i], r);
    const CcCluster cluster = {0,
                               {bound.spread[0][i], bound.spread[1][i], bound.spread[2][i],
                                bound.spread[3][i], bound.spread[4][i], bound.spread[5][i]}};
    const float own = ccDepthBeside(&limits, turn, &cluster, d.depth * voxel, d.normal);
    const float more = ccMax(bound.beside[i], own), less = ccMin(bound.beside[i], own);
    bound.beside[i] = planes.unites[i] ? more : less;
  }
}

}  // namespace

void choosePlanes(const Direction& dir, const FieldData& other, float voxel, bool beside,
                  int wanted, Lanes& lanes) {
  if (wanted == 0) return;
  PlaneLanes planes;
  Deepest best;
  BesideLanes bound;
  planes.sort(lanes, lanes.several, wanted);
  best.begin(padded(wanted));
  if (beside) bound.begin(planes, lanes);
  for (int k = 0; planes.having[k] > 0; ++k) {
    planes.read(other.planes(), k);
    lanes.planes += static_cast<std::size_t>(planes.having[k]);
    const int count = padded(planes.having[k]);
    takePlane(planes, count, best);
    if (beside) boundPlane(dir, planes, voxel, count, bound);
  }
  for (int i = 0; i < wanted; ++i) {
    const std::int32_t lane = planes.lane[i];
    lanes.depth[lane] = (planes.unites[i] ? -best.size[i] : best.size[i]) * voxel;
    lanes.nx[lane] = best.nx[i];
    lanes.ny[lane] = best.ny[i];
    lanes.nz[lane] = best.nz[i];
  }
  if (beside)
    for (int i = 0; i < wanted; ++i) lanes.beside[planes.lane[i]] = bound.beside[i];
}

namespace {

// One plane at the parts from `first` to `last`; `unites`: a plane that is deeper counts.
CC_LANES void takePlaneOfParts(CcVoxel plane, bool unites, int first, int last, Lanes& parts) {
  CC_INDEPENDENT
  for (int i = first; i < last; ++i) {
    const float r[3] = {parts.x[i], parts.y[i], parts.z[i]};
    const CcDepth d = ccPlaneDepth(plane, r);
    const bool counts = unites ? d.depth > parts.depth[i] : d.depth < parts.depth[i];
    parts.nx[i] = counts ? d.normal[0] : parts.nx[i];
    parts.ny[i] = counts ? d.normal[1] : parts.ny[i];
    parts.nz[i] = counts ? d.normal[2] : parts.nz[i];
    parts.depth[i] = counts ? d.depth : parts.depth[i];
  }
}

}  // namespace

void choosePlanesOfParts(const FieldData& other, float voxel, Lanes& parts) {
  for (int first = 0; first < parts.count;) {
    const CcVoxel record = {parts.a[first], parts.b[first]};
    int last = first + 1;
    while (last < parts.count && parts.a[last] == record.a && parts.b[last] == record.b) ++last;
    const bool unites = ccConcave(record);
    std::fill(parts.depth + first, parts.depth + last, unites ? -1e30f : 1e30f);
    for (std::uint32_t k = 0; k < ccPlaneCount(record); ++k)
      takePlaneOfParts(other.planes()[record.b + k], unites, first, last, parts);
    parts.planes += ccPlaneCount(record) * static_cast<std::size_t>(last - first);
    for (int i = first; i < last; ++i) parts.depth[i] *= voxel;
    first = last;
  }
}

namespace {

// Lists those that must be divided if they lie over an edge. Most need not.
CC_LANES int mayDivide(const Direction& dir, Lanes& lanes) {
  const CcLimits limits = dir.limits();
  const float own = dir.voxel;
  const float* const width = lanes.own.width;
  std::int32_t is[kLanes];
  const int all = padded(lanes.count);
  CC_INDEPENDENT
  for (int i = 0; i < all; ++i) {
    const CcVoxel record = {lanes.a[i], lanes.b[i]};
    const int several = (record.a >> 28 & 7u) > 1u;
    is[i] = several & ccMayDivide(&limits, record, lanes.depth[i], lanes.facing[i], width[i], own);
  }
  return listSet<std::int32_t>(is, 1, lanes.count, nullptr, lanes.several);
}

// A sample, and the plane that gives its depth.
struct Edges {
  float depth[kLanes], far[kLanes], nx[kLanes], ny[kLanes], nz[kLanes];
  std::int32_t within[kLanes];

  void begin(const PlaneLanes& planes, const Lanes& lanes, float voxel) {
    for (int i = 0; i < padded(planes.count); ++i) {
      const std::int32_t lane = planes.lane[i];
      depth[i] = lanes.depth[lane];
      far[i] = CC_HALF_DIAGONAL * (lanes.own.width[lane] * voxel);
      nx[i] = lanes.nx[lane], ny[i] = lanes.ny[lane], nz[i] = lanes.nz[lane];
      within[i] = 0;
    }
  }
};

CC_LANES void lookWithin(const PlaneLanes& planes, float voxel, int count, Edges& edges) {
  CC_INDEPENDENT
  for (int i = 0; i < count; ++i) {
    const float r[3] = {planes.x[i], planes.y[i], planes.z[i]};
    const float n[3] = {edges.nx[i], edges.ny[i], edges.nz[i]};
    edges.within[i] |= ccPlaneWithin(planes.plane[i], r, edges.depth[i], n, edges.far[i], voxel);
  }
}

}  // namespace

int edgesWithin(const Direction& dir, const FieldData& other, float voxel, Lanes& lanes) {
  const int listed = mayDivide(dir, lanes);
  if (listed == 0) return 0;
  PlaneLanes planes;
  Edges edges;
  planes.sort(lanes, lanes.several, listed);
  edges.begin(planes, lanes, dir.voxel);
  for (int k = 0; planes.having[k] > 0; ++k) {
    planes.read(other.planes(), k);
    lanes.planes += static_cast<std::size_t>(planes.having[k]);
    lookWithin(planes, voxel, padded(planes.having[k]), edges);
  }
  std::int32_t is[kLanes];
  for (int i = 0; i < listed; ++i) is[planes.lane[i]] = edges.within[i];
  int found = 0;
  for (int i = 0; i < listed; ++i) {
    const std::int32_t lane = lanes.several[i];
    lanes.several[found] = lane;
    found += is[lane];
  }
  return found;
}

}  // namespace cloudcontact::search
