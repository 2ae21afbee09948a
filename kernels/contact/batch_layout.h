// What the host hands to a device for a batch of pairs, and what the device's steps hand to each
// other. Plain C for C++ and OpenCL C; offsets are pinned by a test.
#ifndef CLOUDCONTACT_KERNELS_BATCH_H
#define CLOUDCONTACT_KERNELS_BATCH_H

#include "kernels/contact/contact_patch.h"
#include "kernels/contact/hit_bins.h"
#include "kernels/contact/search.h"

#define CC_LEVELS 3
#define CC_GROUP 128       // work-items that search or sort for a pair together
#define CC_TEAM 32         // that let a pair's bins grow, or add up hits of some of them
#define CC_TEAMS_A_PAIR 8  // of these
#define CC_NEIGHBOURS 64   // of a bin, that there is room for
#define CC_MOST_BINS \
  1024  // of a pair: the table of keys is twice as large and lies in local memory

// Where a field's numbers lie in the one buffer of all fields, each counted in its own type.
typedef struct {
  int nx, ny, nz;  // bricks
  float voxel;     // [m]
  uint firsts, between, distance, records, planes;
  uint samples[CC_LEVELS];  // four floats (x, y, z, width) each, then as many (nx, ny, nz, area)
  uint counts[CC_LEVELS];
  uint cells[CC_LEVELS];  // each sample's cell
  uint finer[CC_LEVELS];  // a cell's run of finer samples: first and count
  uint bricks;            // four floats each: x, y, z, radius
  uint runs;              // of each brick, as `finer`
  uint brickCount;
} CcField;

// One body's samples of a pair, on their way into the other.
typedef struct {
  CcWay way;
  uint own, other;  // fields
  uint hits, room;  // where they go, and how many there fit
  uint nearby[2];   // room for samples near the other body: found on level 2, on level 1
} CcDirection;

typedef struct {
  CcTerms terms;
  double cell;             // a bin's edge [m], of fine samples; twice that of the coarsest
  float margin;            // [m]
  uint enough[CC_LEVELS];  // hits that make a level fine enough
} CcPair;

// What a direction found on a level.
typedef struct {
  uint whole, deep, parts;  // hits, in this order
  uint nearby;              // samples near the other body
  uint asked;               // samples looked up
} CcFound;

// What became of a pair: written for the host.
typedef struct {
  int level;
  uint hits, asked, wanted;  // `wanted`: the most that one direction asked room for
  int failed;                // CC_NO_ROOM ...
  uint firstBin, bins;
  uint firstPatch, patches;  // at last of its contacts
} CcAnswer;

#define CC_NO_ROOM 1   // for hits
#define CC_NO_BINS 2   // for bins, or for patches
#define CC_FINER 8     // on levels that were not searched
#define CC_NO_TOUCH 4  // no hits, but a margin: near misses are the CPU's

// A bin: its cell, its pair, and its hits in the pair's list of them, B's from `middle` on.
typedef struct {
  int cell[3];
  uint pair, begin, middle, end, unused;
} CcBin;

// What growing asks of a bin, out of its sums: a fifth of them, and side by side.
typedef struct {
  double normal[2][3];
  double size[2];  // of its sides' pushes
  double area, first[3], origin[3];
} CcSprout;
#define CC_SPROUT_NUMBERS 15

// A patch: its bins in the order in which they came.
typedef struct {
  uint begin, end;
} CcGrown;

// Counters of a batch.
#define CC_BINS 0
#define CC_PATCHES 1
#define CC_CONTACTS 2
#define CC_COUNTERS 4

// The level that a pair's search came to an end on, of those from `from` on; `found` of its two
// directions on all levels. One less where it has not come to an end.
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
