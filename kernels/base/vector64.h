// Doubles, vectors of three and of two doubles, matrices of 2x2, and rigid placements; vector.h has
// floats. Plain C for C++ and OpenCL C.
#pragma once

#include "kernels/base/language.h"

CC_FN double ccAbs64(double x) {
  return x < 0.0 ? -x : x;
}
CC_FN double ccMin64(double a, double b) {
  return a < b ? a : b;
}
CC_FN double ccMax64(double a, double b) {
  return a > b ? a : b;
}
CC_FN double ccClamp64(double x, double low, double high) {
  return ccMin64(ccMax64(x, low), high);
}
// The square root; 0 for negative numbers.
CC_FN double ccSqrt64(double x) {
  return x > 0.0 ? CC_SQRT64(x) : 0.0;
}

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
CC_FN double ccDot64(CcVec a, CcVec b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
CC_FN CcVec ccCross64(CcVec a, CcVec b) {
  return ccVec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
CC_FN double ccLength64(CcVec a) {
  return CC_SQRT64(ccDot64(a, a));
}
// Scaled to length 1; a zero vector stays.
CC_FN CcVec ccUnit64(CcVec a) {
  const double length = ccLength64(a);
  return length > 0.0 ? ccTimes(1.0 / length, a) : ccVec(0.0, 0.0, 0.0);
}

// Two unit tangents of a unit normal. The first is normal to the axis of its smallest component.
CC_FN void ccTangents64(CcVec n, CcVec* t1, CcVec* t2) {
  const double x = ccAbs64(n.x), y = ccAbs64(n.y), z = ccAbs64(n.z);
  const int first = x <= y && x <= z, second = !first && y <= z;
  const CcVec aside = first    ? ccVec(0.0, n.z, -n.y)
                      : second ? ccVec(-n.z, 0.0, n.x)
                               : ccVec(n.y, -n.x, 0.0);
  *t1 = ccUnit64(aside);
  *t2 = ccCross64(n, *t1);
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

// The inverse of m with `more` added to its diagonal, which must not be singular.
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

// The symmetric square root of a matrix whose eigenvalues are not negative but for rounding. By
// Cayley and Hamilton it is (m + sqrt(det)) / sqrt(trace + 2 sqrt(det)).
CC_FN CcSymmetric2 ccMatrixRoot(CcSymmetric2 m) {
  const double d = ccSqrt64(m.uu * m.vv - m.uv * m.uv);
  const double length = ccSqrt64(m.uu + m.vv + 2.0 * d), scale = length > 0.0 ? 1.0 / length : 0.0;
  const CcSymmetric2 root = {scale * (m.uu + d), scale * m.uv, scale * (m.vv + d)};
  return root;
}

// A rigid placement, x -> turn x + shift; `turn` by rows.
typedef struct {
  double turn[9], shift[3];
} CcPlacement;

CC_FN CcVec ccTurned(CC_GLOBAL const CcPlacement* p, CcVec v) {
  return ccVec(ccDot64(ccVecAt(p->turn), v), ccDot64(ccVecAt(p->turn + 3), v),
               ccDot64(ccVecAt(p->turn + 6), v));
}
CC_FN CcVec ccPlaced(CC_GLOBAL const CcPlacement* p, CcVec v) {
  return ccPlus(ccTurned(p, v), ccVecAt(p->shift));
}
