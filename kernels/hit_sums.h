// What hits add up to, in a bin and in a patch. Nearly all sums are a weight times the vector
// (1, x, y, z). Plain C for C++ and OpenCL C; offsets are pinned by a test.
//
// C++ keeps the vector in a register of four doubles. On a device four work-items share it, each
// its part of it: one work-item's registers would not hold a bin's sums. They add up the same
// products in the same order (sums.cl, growth.cl).
#ifndef CLOUDCONTACT_KERNELS_HIT_SUMS_H
#define CLOUDCONTACT_KERNELS_HIT_SUMS_H

#include "sample.h"

#if defined(__OPENCL_VERSION__)
#define CC_MAY_ALIAS
#else
#define CC_MAY_ALIAS __attribute__((may_alias))  // C++ names the same places by its own types
#endif

// A side's: by whose surface pushes.
typedef struct CC_MAY_ALIAS {
  double push[3], moment[3], wall[3];
  double size;
  double depth[3];
} CcSideSums;

// Sums, in C++ (plugin/contact/sums.h tells what each is); matrices by columns.
typedef struct CC_MAY_ALIAS {
  double origin[3];
  CcSideSums side[2];
  double area, width, facing;
  double first[3];
  double second[9];
  double normal[2][3];
  double normalBy[2][9];
  double place[3];
  double middle;
  double apart[3];
  double opening;
  double deepest;
  double deep;
  int hits, unused;
} CcSums;

// What a hit weighs, in units.
typedef struct {
  double whole, pressed;  // area, and area times depth
  double w, f, blind;     // wet and pressed as far as it faces the other body; the rest of pressed
  double weighed;
  double x[3];
} CcWeights;

// `at` the hit's place, `area` of its whole sample; `gate` how far it faces the other body, 0..1;
// `perUnit` [1/m].
CC_FN CcWeights ccWeightsOf(const float* at, float area, const CcWet* wet, double gate,
                            const double* origin, double perUnit) {
  CcWeights h;
  h.whole = area * perUnit * perUnit;
  h.pressed = h.whole * (wet->depth1 * perUnit);
  h.w = gate * h.whole * wet->share;
  h.f = gate * h.pressed;
  h.blind = h.pressed - h.f;
  h.weighed = gate * h.whole * perUnit * perUnit;
  for (int i = 0; i < 3; ++i) h.x[i] = (at[i] - origin[i]) * perUnit;
  return h;
}

#if !defined(__OPENCL_VERSION__)

typedef double CcFour __attribute__((vector_size(32)));
#define CC_FOUR(p, q, r, s) \
  CcFour {                  \
    p, q, r, s              \
  }
#define CC_NO_FOUR \
  CcFour {}

// Sums of hits of one body while they are added up, lengths in units; three rows n_j (1, x, y, z)
// each; own and other: by whose normals.
typedef struct {
  CcFour area, faced;  // times (1, x, y, z)
  CcFour second[3], normalOwn[3], normalOther[3], apart[3], pushOwn[3], pushOther[3];
  CcFour powers;              // pressed, squares, cubes, areas of whole samples
  CcFour wallOwn, wallOther;  // (0, x, y, z)
  double middle;
  float deepest;
} CcAdding;

// The same, added up.
typedef struct {
  double area[4], faced[4];
  double second[3][4], normalOwn[3][4], normalOther[3][4], apart[3][4], pushOwn[3][4],
      pushOther[3][4];
  double powers[4], wallOwn[4], wallOther[4];
  double middle, deepest;
} CcAdded;
#define CC_ADDED_FOURS 23  // of CcAdding, and of CcAdded

CC_FN CcAdding ccNothingAdded(void) {
  CcAdding a;
  a.area = a.faced = a.powers = a.wallOwn = a.wallOther = CC_NO_FOUR;
  for (int i = 0; i < 3; ++i) {
    a.second[i] = a.normalOwn[i] = a.normalOther[i] = CC_NO_FOUR;
    a.apart[i] = a.pushOwn[i] = a.pushOther[i] = CC_NO_FOUR;
  }
  a.middle = 0.0;
  a.deepest = -1e30f;
  return a;
}

// Three rows more of (nx, ny, nz) times v.
CC_FN void ccAddRows(CcFour* rows, double nx, double ny, double nz, CcFour v) {
  rows[0] += nx * v;
  rows[1] += ny * v;
  rows[2] += nz * v;
}

// One hit more: `depth` at the sample. `both`: it stands for the other's surface too.
CC_FN void ccAddHit(CcAdding* sums, const float* at, const float* own, const float* other,
                    float area, const CcWet* wet, float depth, double gate, const double* origin,
                    double perUnit, int both) {
  const CcWeights h = ccWeightsOf(at, area, wet, gate, origin, perUnit);
  const double x = h.x[0], y = h.x[1], z = h.x[2];
  const CcFour v = CC_FOUR(1.0, x, y, z);
  const double nx = own[0], ny = own[1], nz = own[2];
  const double mx = other[0], my = other[1], mz = other[2];
  sums->area += h.w * v;
  sums->faced += h.f * v;
  ccAddRows(sums->second, h.w * x, h.w * y, h.w * z, v);
  ccAddRows(sums->normalOwn, h.w * nx, h.w * ny, h.w * nz, v);
  ccAddRows(sums->normalOther, h.w * mx, h.w * my, h.w * mz, v);
  ccAddRows(sums->apart, h.f * (nx + mx), h.f * (ny + my), h.f * (nz + mz), v);
  ccAddRows(sums->pushOwn, h.pressed * nx, h.pressed * ny, h.pressed * nz, v);
  sums->wallOwn += h.blind * (CC_FOUR(0.0, nx, ny, nz));
  if (both) {
    ccAddRows(sums->pushOther, h.pressed * mx, h.pressed * my, h.pressed * mz, v);
    sums->wallOther += h.blind * (CC_FOUR(0.0, mx, my, mz));
  }
  sums->powers +=
      CC_FOUR(h.pressed, h.weighed * wet->depth2, h.weighed * perUnit * wet->depth3, h.w * h.whole);
  sums->middle += h.f * (depth * perUnit);
  sums->deepest = ccMax(sums->deepest, depth);
}

// A body's surface in a bin: its normals' sums, and, where it pushes, the push.
CC_FN void ccGiveSide(CcSums* sums, int s, const CcAdded* from, int own, int pushes, double unit) {
  const double u2 = unit * unit, u3 = u2 * unit, u4 = u2 * u2;
  const double(*normal)[4] = own ? from->normalOwn : from->normalOther;
  const double(*push)[4] = own ? from->pushOwn : from->pushOther;
  const double* wall = own ? from->wallOwn : from->wallOther;
  CcSideSums* to = &sums->side[s];
  for (int j = 0; j < 3; ++j) {
    sums->normal[s][j] += u2 * normal[j][0];
    for (int i = 0; i < 3; ++i) sums->normalBy[s][3 * i + j] += u3 * normal[j][1 + i];
    if (!pushes) continue;
    // The vector that belongs to a matrix n x^T: sum of x cross n.
    const int p = (j + 1) % 3, q = (j + 2) % 3;
    to->push[j] += u3 * push[j][0];
    to->moment[j] += u4 * (push[q][1 + p] - push[p][1 + q]);
    to->wall[j] += u3 * wall[1 + j];
  }
  if (!pushes) return;
  to->size += u3 * from->powers[0];
  to->depth[0] += u3 * from->faced[0];
  to->depth[1] += u4 * from->powers[1];
  to->depth[2] += u4 * unit * from->powers[2];
}

// What was added, in lengths of `unit` [m], goes to `sums`; `side`: whose samples these were.
CC_FN void ccGive(CcSums* sums, const CcAdded* from, int hits, int oneSided, int side,
                  double unit) {
  const double u2 = unit * unit, u3 = u2 * unit, u4 = u2 * u2;
  for (int i = 0; i < 3; ++i) {
    sums->first[i] += u3 * from->area[1 + i];
    sums->place[i] += u4 * from->faced[1 + i];
    sums->apart[i] += u3 * from->apart[i][0];
    for (int j = 0; j < 3; ++j) sums->second[3 * i + j] += u4 * from->second[j][1 + i];
  }
  ccGiveSide(sums, side, from, 1, 1, unit);
  ccGiveSide(sums, 1 - side, from, 0, oneSided, unit);
  sums->area += u2 * from->area[0];
  sums->facing += u3 * from->faced[0];
  sums->opening += u4 * (from->apart[0][1] + from->apart[1][2] + from->apart[2][3]);
  sums->width += u4 * from->powers[3];
  sums->middle += u4 * from->middle;
  sums->deepest = sums->deepest < from->deepest ? from->deepest : sums->deepest;
  sums->hits += hits;
}

// One bin's sums more to a patch's, about the patch's origin.
CC_FN void ccJoinSums(CcSums* to, const CcSums* from) {
  double shift[3];
  for (int i = 0; i < 3; ++i) shift[i] = from->origin[i] - to->origin[i];
  for (int s = 0; s < 2; ++s) {
    CcSideSums* a = &to->side[s];
    const CcSideSums* b = &from->side[s];
    for (int i = 0; i < 3; ++i) {
      const int p = (i + 1) % 3, q = (i + 2) % 3;
      a->push[i] += b->push[i];
      a->moment[i] += b->moment[i] + (shift[p] * b->push[q] - shift[q] * b->push[p]);
      a->wall[i] += b->wall[i];
      a->depth[i] += b->depth[i];
      to->normal[s][i] += from->normal[s][i];
      for (int j = 0; j < 3; ++j)
        to->normalBy[s][3 * i + j] += from->normalBy[s][3 * i + j] + from->normal[s][j] * shift[i];
    }
    a->size += b->size;
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      to->second[3 * i + j] += from->second[3 * i + j] + from->first[j] * shift[i] +
                               shift[j] * from->first[i] + from->area * shift[j] * shift[i];
    to->first[i] += from->first[i] + from->area * shift[i];
    to->place[i] += from->place[i] + from->facing * shift[i];
    to->apart[i] += from->apart[i];
  }
  to->area += from->area;
  to->width += from->width;
  to->facing += from->facing;
  to->middle += from->middle;
  to->opening += from->opening + (shift[0] * from->apart[0] + shift[1] * from->apart[1] +
                                  shift[2] * from->apart[2]);
  to->deep += from->deep;
  to->deepest = to->deepest < from->deepest ? from->deepest : to->deepest;
  to->hits += from->hits;
}

#endif

#endif
