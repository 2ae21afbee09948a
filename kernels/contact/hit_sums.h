// Sums over the hits of a bin or a patch (docs/force.md, "Bins"). Nearly all are a weight times the
// vector (1, x, y, z). Plain C for C++ and OpenCL C; a test checks the offsets.
//
// C++ keeps the vector in a register of four doubles. On a device a team shares the sums, one row a
// work-item, because the registers of one work-item cannot hold a bin. It adds the same products in
// the same order (sums.cl, patch_sums.cl).
#ifndef CLOUDCONTACT_KERNELS_HIT_SUMS_H
#define CLOUDCONTACT_KERNELS_HIT_SUMS_H

#include "kernels/contact/sample.h"

// Sums over the samples of one body. Normals are that body's outward normals; a push is an area
// times a depth times a normal.
typedef struct {
  double push[3];    // sum a d n [m^3]
  double moment[3];  // sum a d (x - origin) x n [m^4]
  double wall[3];    // the part of `push` by samples that do not face the other body [m^3]
  double size;       // sum a d [m^3]
  double depth[3];   // sum a d^k of facing samples, k = 1..3
} CcSideSums;

// A bin or a patch: sums over its hits about `origin`, in the frame body [m]. Matrices by columns.
typedef struct {
  double origin[3];
  CcSideSums side[2];     // A's samples, B's samples
  double area;            // in contact, of facing samples of both bodies [m^2]
  double width;           // sum over these of a times the whole sample's area [m^4]
  double facing;          // sum a d of facing samples of both bodies [m^3]
  double first[3];        // sum a x
  double second[9];       // sum a x x^T
  double normal[2][3];    // sum a n of A's surface and of B's
  double normalBy[2][9];  // sum a n x^T of each
  // Of facing samples of both bodies, weighted by a d (the weights add up to `facing`):
  double place[3];  // x [m^4]
  double middle;    // depth at the sample's middle [m^4]
  double apart[3];  // sum of both outward normals [m^3]
  double opening;   // that sum times x [m^4]
  double deepest;   // largest depth at a sample [m]
  double deep;      // part of both sides' `size` by samples below the band
  int hits, unused;
} CcSums;

// Offsets in CcSums, counted in doubles; a test checks them.
#define CC_SUMS_NUMBERS 79
#define CC_SIDES 3
#define CC_SIDE_NUMBERS 13
#define CC_MOMENT 3  // from its side's first
#define CC_WALL 6
#define CC_SIZE 9
#define CC_DEPTHS 10
#define CC_AREA 29
#define CC_WIDTH 30
#define CC_PRESSED 31
#define CC_FIRST 32
#define CC_SECOND 35
#define CC_NORMALS 44
#define CC_NORMALS_BY 50
#define CC_PLACES 68
#define CC_MIDDLE 71
#define CC_APART 72
#define CC_OPENING 75
#define CC_DEEPEST 76
#define CC_DEEP_PRESSED 77
#define CC_HITS 78

// The weights of a hit, in lengths of `unit`: whole area; area times depth; both gated by how far
// the hit faces the other body (w, f); the rest (blind); and the weight of the powers of depth. For
// one hit, or for several in vectors of `Number`.
#define CC_WEIGHTS(Number, area, share, depth1, gate, perUnit) \
  const Number whole = (area) * (perUnit) * (perUnit);         \
  const Number pressed = whole * ((depth1) * (perUnit));       \
  const Number w = (gate)*whole * (share), f = (gate)*pressed; \
  const Number blind = pressed - f;                            \
  const Number weighed = (gate)*whole * (perUnit) * (perUnit)

typedef struct {
  double whole, pressed, w, f, blind, weighed;
  double x[3];
} CcWeights;

// `at`: the hit's place; `area`: of its whole sample; `gate`: how far it faces the other body,
// 0..1; `perUnit`: 1/unit [1/m].
CC_FN CcWeights ccWeightsOf(const float* at, float area, const CcWet* wet, double gate,
                            const double* origin, double perUnit) {
  CC_WEIGHTS(double, area, wet->share, wet->depth1, gate, perUnit);
  CcWeights h = {whole, pressed, w, f, blind, weighed, {0.0, 0.0, 0.0}};
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

// Running sums over hits of one body, with lengths in units. Matrices are three rows n_j (1, x, y,
// z). Own and other say whose normals.
typedef struct {
  CcFour area, faced;  // times (1, x, y, z)
  CcFour second[3], normalOwn[3], normalOther[3], apart[3], pushOwn[3], pushOther[3];
  CcFour powers;              // pressed, squares, cubes, areas of whole samples
  CcFour wallOwn, wallOther;  // (0, x, y, z)
  double middle;
  float deepest;
} CcAdding;

// The final sums.
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

// Adds three rows of (nx, ny, nz) times v.
CC_FN void ccAddRows(CcFour* rows, double nx, double ny, double nz, const CcFour* v) {
  rows[0] += nx * *v;
  rows[1] += ny * *v;
  rows[2] += nz * *v;
}

// Adds a hit. `depth`: at the sample. `both`: the hit also stands for the other body's surface.
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
  ccAddRows(sums->second, h.w * x, h.w * y, h.w * z, &v);
  ccAddRows(sums->normalOwn, h.w * nx, h.w * ny, h.w * nz, &v);
  ccAddRows(sums->normalOther, h.w * mx, h.w * my, h.w * mz, &v);
  ccAddRows(sums->apart, h.f * (nx + mx), h.f * (ny + my), h.f * (nz + mz), &v);
  ccAddRows(sums->pushOwn, h.pressed * nx, h.pressed * ny, h.pressed * nz, &v);
  sums->wallOwn += h.blind * (CC_FOUR(0.0, nx, ny, nz));
  if (both) {
    ccAddRows(sums->pushOther, h.pressed * mx, h.pressed * my, h.pressed * mz, &v);
    sums->wallOther += h.blind * (CC_FOUR(0.0, mx, my, mz));
  }
  sums->powers +=
      CC_FOUR(h.pressed, h.weighed * wet->depth2, h.weighed * perUnit * wet->depth3, h.w * h.whole);
  sums->middle += h.f * (depth * perUnit);
  sums->deepest = ccMax(sums->deepest, depth);
}

// The same for eight bins side by side, one lane each, in contacts of two clouds: only the numbers
// that ccGive() reads of those, in CC_LANE_SUMS rows of eight.
#define CC_SUM_LANES 8
#define CC_LANE_SUMS 64

typedef double CcEight __attribute__((vector_size(64)));
typedef long CcEightBits __attribute__((vector_size(64)));

// A hit in each lane, as for ccAddHit(); places are from the lane's origin, in units.
typedef struct {
  CcEight x[3], own[3], other[3];
  CcEight area, share, depth1, depth2, depth3, depth, gate;
} CcEightHits;

// Adds a hit to each lane, with the same products as ccAddHit(). A lane without bits in `keep`
// starts from zero.
CC_FN void ccAddInLanes(CcEight* sums, const CcEightHits* hit, const CcEightBits* keep,
                        double perUnit) {
  const CcEightBits old = *keep;
  const CcEight x = hit->x[0], y = hit->x[1], z = hit->x[2];
  const CcEight nx = hit->own[0], ny = hit->own[1], nz = hit->own[2];
  const CcEight mx = hit->other[0], my = hit->other[1], mz = hit->other[2];
  CC_WEIGHTS(CcEight, hit->area, hit->share, hit->depth1, hit->gate, perUnit);
#define CC_ADD(k, value) sums[k] = (CcEight)((CcEightBits)sums[k] & old) + (value)
#define CC_ADD_FOUR(k, value)                                               \
  CC_ADD(k, value), CC_ADD((k) + 1, (value)*x), CC_ADD((k) + 2, (value)*y), \
      CC_ADD((k) + 3, (value)*z)
#define CC_ADD_THREE(k, value) \
  CC_ADD(k, (value)*x), CC_ADD((k) + 1, (value)*y), CC_ADD((k) + 2, (value)*z)
  CC_ADD_FOUR(0, w), CC_ADD_FOUR(4, f);
  CC_ADD_THREE(8, w * x), CC_ADD_THREE(11, w * y), CC_ADD_THREE(14, w * z);
  CC_ADD_FOUR(17, w * nx), CC_ADD_FOUR(21, w * ny), CC_ADD_FOUR(25, w * nz);
  CC_ADD_FOUR(29, w * mx), CC_ADD_FOUR(33, w * my), CC_ADD_FOUR(37, w * mz);
  const CcEight ax = f * (nx + mx), ay = f * (ny + my), az = f * (nz + mz);
  CC_ADD(41, ax), CC_ADD(42, ax * x), CC_ADD(43, ay), CC_ADD(44, ay * y), CC_ADD(45, az);
  CC_ADD(46, az * z);
  const CcEight px = pressed * nx, py = pressed * ny, pz = pressed * nz;
  CC_ADD(47, px), CC_ADD(48, px * y), CC_ADD(49, px * z), CC_ADD(50, py), CC_ADD(51, py * x);
  CC_ADD(52, py * z), CC_ADD(53, pz), CC_ADD(54, pz * x), CC_ADD(55, pz * y);
  CC_ADD(56, blind * nx), CC_ADD(57, blind * ny), CC_ADD(58, blind * nz);
  CC_ADD(59, pressed), CC_ADD(60, weighed * hit->depth2);
  CC_ADD(61, weighed * perUnit * hit->depth3), CC_ADD(62, w * whole);
  CC_ADD(63, f * (hit->depth * perUnit));
#undef CC_ADD
#undef CC_ADD_FOUR
#undef CC_ADD_THREE
}

// The sums of one lane.
CC_FN CcAdded ccTakeLane(const CcEight* sums, int lane, double deepest) {
#define CC_OF(k) sums[k][lane]
  CcAdded a;
  for (int i = 0; i < 4; ++i) {
    a.area[i] = CC_OF(i);
    a.faced[i] = CC_OF(4 + i);
    for (int j = 0; j < 3; ++j) {
      a.second[j][i] = i > 0 ? CC_OF(8 + 3 * j + i - 1) : 0.0;
      a.normalOwn[j][i] = CC_OF(17 + 4 * j + i);
      a.normalOther[j][i] = CC_OF(29 + 4 * j + i);
      a.apart[j][i] = i == 0 ? CC_OF(41 + 2 * j) : i == j + 1 ? CC_OF(42 + 2 * j) : 0.0;
      a.pushOther[j][i] = 0.0;
    }
    a.powers[i] = CC_OF(59 + i);
    a.wallOwn[i] = i > 0 ? CC_OF(56 + i - 1) : 0.0;
    a.wallOther[i] = 0.0;
  }
  const double pushed[3][4] = {{CC_OF(47), 0.0, CC_OF(48), CC_OF(49)},
                               {CC_OF(50), CC_OF(51), 0.0, CC_OF(52)},
                               {CC_OF(53), CC_OF(54), CC_OF(55), 0.0}};
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 4; ++i) a.pushOwn[j][i] = pushed[j][i];
  a.middle = CC_OF(63);
  a.deepest = deepest;
#undef CC_OF
  return a;
}

// Adds one body's surface to a bin: the sums of its normals and, if it pushes, its push.
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

// Adds final sums, in lengths of `unit` [m], to `sums`. `side`: whose samples they are.
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

// Adds a bin's sums to a patch's, about the patch's origin.
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
