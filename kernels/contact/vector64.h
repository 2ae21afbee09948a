// Vectors of three and of two doubles, symmetric matrices of two, and rigid maps. Plain C for C++
// and OpenCL C.
#ifndef CLOUDCONTACT_KERNELS_VECTOR64_H
#define CLOUDCONTACT_KERNELS_VECTOR64_H

#include "kernels/base/number64.h"
#include "kernels/contact/field_voxel.h"

typedef struct {
  double x, y, z;
} CcVec;

CC_FN CcVec ccVec(double x, double y, double z) {
  const CcVec v = {x, y, z};
  return v;
}
CC_FN CcVec ccVecAt(CC_GLOBAL const double* v) {
  return ccVec(v[0], v[1], v[2]);
}
CC_FN CcVec ccPlus(CcVec a, CcVec b) {
  return ccVec(a.x + b.x, a.y + b.y, a.z + b.z);
}
CC_FN CcVec ccMinus(CcVec a, CcVec b) {
  return ccVec(a.x - b.x, a.y - b.y, a.z - b.z);
}
CC_FN CcVec ccTimes(double f, CcVec a) {
  return ccVec(f * a.x, f * a.y, f * a.z);
}
CC_FN double ccDotOf(CcVec a, CcVec b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
CC_FN CcVec ccCrossOf(CcVec a, CcVec b) {
  return ccVec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
CC_FN double ccLengthOf(CcVec a) {
  return CC_SQRT64(ccDotOf(a, a));
}
// Of length one; nothing stays nothing.
CC_FN CcVec ccUnit(CcVec a) {
  const double length = ccLengthOf(a);
  return length > 0.0 ? ccTimes(1.0 / length, a) : ccVec(0.0, 0.0, 0.0);
}

CC_FN double ccWithin(double x, double low, double high) {
  return ccLess(ccMore(x, low), high);
}
CC_FN double ccSize(double x) {
  return x < 0.0 ? -x : x;
}
CC_FN double ccRoot(double x) {
  return x > 0.0 ? CC_SQRT64(x) : 0.0;
}

typedef struct {
  double u, v;
} CcTwo;

// By rows.
typedef struct {
  double uu, uv, vu, vv;
} CcMatrix2;

typedef struct {
  double uu, uv, vv;
} CcSymmetric2;

CC_FN CcTwo ccTwo(double u, double v) {
  const CcTwo t = {u, v};
  return t;
}
CC_FN CcTwo ccOn(CcSymmetric2 m, CcTwo x) {
  return ccTwo(m.uu * x.u + m.uv * x.v, m.uv * x.u + m.vv * x.v);
}
CC_FN CcTwo ccTurn2(CcMatrix2 m, CcTwo x) {
  return ccTwo(m.uu * x.u + m.uv * x.v, m.vu * x.u + m.vv * x.v);
}

// With `more` added to the diagonal; m must not be singular then.
CC_FN CcSymmetric2 ccInverse(CcSymmetric2 m, double more) {
  const double uu = m.uu + more, vv = m.vv + more, scale = 1.0 / (uu * vv - m.uv * m.uv);
  const CcSymmetric2 inverse = {scale * vv, -scale * m.uv, scale * uu};
  return inverse;
}

CC_FN CcMatrix2 ccTimesSymmetric(CcMatrix2 a, CcSymmetric2 b) {
  const CcMatrix2 m = {a.uu * b.uu + a.uv * b.uv, a.uu * b.uv + a.uv * b.vv,
                       a.vu * b.uu + a.vv * b.uv, a.vu * b.uv + a.vv * b.vv};
  return m;
}

// The symmetric root of a matrix without negative eigenvalues but for rounding: by Cayley and
// Hamilton, (m + root(det)) / root(trace + 2 root(det)).
CC_FN CcSymmetric2 ccRootOf(CcSymmetric2 m) {
  const double d = ccRoot(m.uu * m.vv - m.uv * m.uv);
  const double length = ccRoot(m.uu + m.vv + 2.0 * d), scale = length > 0.0 ? 1.0 / length : 0.0;
  const CcSymmetric2 root = {scale * (m.uu + d), scale * m.uv, scale * (m.vv + d)};
  return root;
}

// r m r.
CC_FN CcSymmetric2 ccBothSides(CcSymmetric2 r, CcSymmetric2 m) {
  const CcMatrix2 full = {r.uu, r.uv, r.uv, r.vv}, once = ccTimesSymmetric(full, m);
  const CcSymmetric2 both = {once.uu * r.uu + once.uv * r.uv, once.uu * r.uv + once.uv * r.vv,
                             once.vu * r.uv + once.vv * r.vv};
  return both;
}

// A rigid placement, x -> turn x + shift; `turn` by rows.
typedef struct {
  double turn[9], shift[3];
} CcPlacement;

CC_FN CcVec ccTurned(CC_GLOBAL const CcPlacement* p, CcVec v) {
  return ccVec(ccDotOf(ccVecAt(p->turn), v), ccDotOf(ccVecAt(p->turn + 3), v),
               ccDotOf(ccVecAt(p->turn + 6), v));
}
CC_FN CcVec ccPlaced(CC_GLOBAL const CcPlacement* p, CcVec v) {
  return ccPlus(ccTurned(p, v), ccVecAt(p->shift));
}

#endif
