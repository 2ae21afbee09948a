// A pair's edges: a team finds each body's deepest hit, and looks the sharp points near it up, each
// work-item those of some voxels (sharp_point.h).

#define CC_NOT_DEEP -1e30f  // less than any hit's depth

// The fields of a batch.
typedef struct {
  __global const CcField* fields;
  __global const CcVoxel* records;
  __global const int* ints;
} CcSharpData;

// Local memory of a team.
typedef struct {
  CcSharpWay way;
  float depths[CC_TEAM];
  uint numbers[CC_TEAM];
} CcSharpRoom;

CcRecords ccRecordsOf(uint field, const CcSharpData* all) {
  __global const CcField* f = &all->fields[field];
  const CcRecords r = {{f->nx, f->ny, f->nz}, all->ints + f->firsts, all->records + f->records,
                       all->records + f->planes};
  return r;
}

// The deepest of what the team's work-items have, of several the first; its number, or ~0.
uint ccDeepestOf(__local const CcSharpRoom* room, float* depth) {
  uint which = ~0u;
  for (int k = 0; k < CC_TEAM; ++k) {
    const uint number = room->numbers[k];
    const float own = room->depths[k];
    if (number == ~0u) continue;
    if (which != ~0u && !(own > *depth) && !(own == *depth && number < which)) continue;
    *depth = own;
    which = number;
  }
  return which;
}

// The number of the deepest of a body's hits, or ~0.
uint ccDeepestHit(__local CcSharpRoom* room, __global const float4* hits, uint count) {
  const uint lid = get_local_id(0);
  float depth = CC_NOT_DEEP;
  uint which = ~0u;
  for (uint i = lid; i < count; i += CC_TEAM) {
    const float own = hits[i].w;
    if (which != ~0u && !(own > depth)) continue;
    depth = own;
    which = i;
  }
  room->depths[lid] = depth;
  room->numbers[lid] = which;
  barrier(CLK_LOCAL_MEM_FENCE);
  which = ccDeepestOf(room, &depth);
  barrier(CLK_LOCAL_MEM_FENCE);
  return which;
}

// The depth [the other's voxels] of a body's sharp points near a hit; 0: none.
float ccSharpest(__local CcSharpRoom* room, __global const float4* hits, size_t columns, uint hit,
                 int level) {
  const uint lid = get_local_id(0);
  float deepest = 0.0f;
  if (hit != ~0u) {
    const float4 p = hits[hit], q = hits[columns + hit], v = hits[3 * columns + hit];
    const float at[3] = {p.x, p.y, p.z}, normal[3] = {q.x, q.y, q.z};
    float sample[3], middle[3];
    ccSampleOfHit(&room->way, at, normal, v.y / v.x, sample);
    for (int k = (int)lid; k < ccSharpVoxels(level); k += CC_TEAM) {
      ccSharpMiddle(sample, level, k, middle);
      deepest = ccSharpIn(&room->way, middle, deepest);
    }
  }
  room->depths[lid] = deepest;
  room->numbers[lid] = lid;
  barrier(CLK_LOCAL_MEM_FENCE);
  ccDeepestOf(room, &deepest);
  barrier(CLK_LOCAL_MEM_FENCE);
  return deepest;
}

// The depth [m] of a body's edges in the other. `found`: of its samples, by level; a `level` that
// there is not asks for nothing. Barriers are in no branches.
double ccEdgeOf(__global const CcDirection* dir, __global const CcFound* found, int level,
                const CcSharpData* all, __global const float4* hits, __local CcSharpRoom* room) {
  if (get_local_id(0) == 0) {
    room->way.own = ccRecordsOf(dir->own, all);
    room->way.other = ccRecordsOf(dir->other, all);
    room->way.toOther = dir->way.toOther;
    room->way.toFrame = dir->way.toFrame;
    room->way.voxel = all->fields[dir->own].voxel;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  uint count = 0;
  if (level < CC_LEVELS) count = found[level].whole + found[level].deep + found[level].parts;
  __global const float4* own = hits + 4 * (size_t)dir->hits;
  const uint hit = ccDeepestHit(room, own, count);
  return (double)ccSharpest(room, own, dir->room, hit, level) * all->fields[dir->other].voxel;
}
