// The data that host and device, and the device's kernels, exchange about a batch of pairs. Plain C
// for C++ and OpenCL C; a test checks the offsets.
#ifndef CLOUDCONTACT_KERNELS_BATCH_H
#define CLOUDCONTACT_KERNELS_BATCH_H

#include "kernels/contact/contact_patch.h"
#include "kernels/contact/hit_bins.h"
#include "kernels/contact/shape_depth.h"

#define CC_LEVELS 3
#define CC_GROUP 128       // work-items that search or sort for one pair
#define CC_TEAM 32         // work-items that grow a pair's patches, sum hits, or place points
#define CC_TEAMS_A_PAIR 8  // that sum hits
#define CC_LINING_UP 4     // teams that line up the hits of a patch
#define CC_NEIGHBORS 64    // most neighbors of a bin
// Most bins of a pair: a table of keys, twice as large, is in local memory.
#define CC_MOST_BINS 1024

// Offsets of a field's numbers in the one buffer of all fields, each counted in its own type.
typedef struct {
  int nx, ny, nz;  // bricks
  float voxel;     // [m]
  uint firsts, between, distance, records, planes;
  uint samples[CC_LEVELS];  // four floats (x, y, z, width) each, then as many (nx, ny, nz, area)
  uint counts[CC_LEVELS];
  uint clusters[CC_LEVELS];  // CcCluster of each, in eight floats; none on level 0
  uint cells[CC_LEVELS];     // each sample's cell
  uint finer[CC_LEVELS];     // run of finer samples of a cell: first and count
  uint bricks;               // four floats each: x, y, z, radius
  uint runs;                 // of each brick, like `finer`
  uint brickCount;
} CcField;

// One direction of a pair: the samples of one body looked up in the other. A shape has no samples:
// its direction has the other's fields and hits, and is not searched.
typedef struct {
  CcWay way;
  uint own, other;  // fields
  uint hits, room;  // first hit, and how many there is room for
  uint nearby[2];   // offsets for samples near the other body, of levels 2 and 1
} CcDirection;

typedef struct {
  CcTerms terms;
  double cell;   // edge of a bin's cell [m] for fine samples; the coarsest level takes twice that
  float margin;  // [m]
  uint enough[CC_LEVELS];  // hits that make a level fine enough
  CcDirection ways[2];     // A's samples in B, and B's in A
} CcPair;

// The results of a direction on one level.
typedef struct {
  uint whole, deep, parts;  // hits, in this order
  uint nearby;              // samples near the other body
  uint lookups;             // samples looked up
} CcFound;

// The result of a pair, for the host.
typedef struct {
  int level;
  uint hits, lookups, needed;  // `needed`: room for hits that the direction with more of them needs
  int failed;                  // CC_NO_ROOM and so on
  uint firstBin, bins;
  uint firstPatch, patches;  // in the end, of its contacts
} CcAnswer;

#define CC_NO_ROOM 1      // no room for its hits
#define CC_NO_BINS 2      // no room for its bins or patches
#define CC_FINER 8        // needs levels that were not searched
#define CC_NO_TOUCH 4     // no hits, but a margin: the CPU finds near misses
#define CC_SHAPE_EDGE 16  // an edge of a shape touches: the CPU finds its depth

// A bin: its cell, its pair, and its hits in the pair's list; B's hits begin at `middle`.
typedef struct {
  int cell[3];
  uint pair, begin, middle, end, unused;
} CcBin;

// The part of a bin's sums that growing reads, a fifth of them.
typedef struct {
  double normal[2][3];
  double size[2];  // of both sides' pushes
  double area, first[3], origin[3];
} CcSprout;
#define CC_SPROUT_NUMBERS 15

// A patch: its bins, in the order in which they joined.
typedef struct {
  uint begin, end;
} CcGrown;

// A hit's normals: of the body whose sample it is and of the other, and that sample's area.
typedef struct {
  float own[3], other[3], area;
  int side;
} CcFacing;

// A contact: its pair and patch, where the patch's hits are lined up, the edge of a bin's cell, and
// the pair's voxel [m].
typedef struct {
  uint pair, patch, begin, count;
  double cell, voxel;
} CcListed;

// A contact's points on the way to their places, what is nearest to each, and whether that is asked
// (again, as places moved).
typedef struct {
  CcPlan plan;
  CcNearestHit found[4];
  int moved, unused;
} CcPlaced;

// Counters of a batch.
#define CC_BINS 0
#define CC_PATCHES 1
#define CC_CONTACTS 2
#define CC_COUNTERS 4

// What the host reads, but for the contacts, which follow in the same buffer.
typedef struct {
  uint counters[CC_COUNTERS];
  CcAnswer answers[1];  // one for each pair
} CcResults;

// The level on which a pair's search ended, of the levels down to `from`; one less if it has not
// ended. `found`: of both directions on all levels.
CC_FN int ccLastLevel(CC_GLOBAL const CcPair* pair, CC_GLOBAL const CcFound* found, int from) {
  for (int level = CC_LEVELS - 1; level >= from && level > 0; --level) {
    uint hits = 0;
    for (int d = 0; d < 2; ++d) {
      CC_GLOBAL const CcFound* f = &found[d * CC_LEVELS + level];
      hits += f->whole + f->deep + f->parts;
    }
    if (hits >= pair->enough[level]) return level;
  }
  return from - 1 > 0 ? from - 1 : 0;
}

#endif
