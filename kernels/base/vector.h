// Floats and vectors of three floats; vector64.h has the same in double. Plain C for C++ and
// OpenCL C.
#pragma once

#include "kernels/base/language.h"

CC_FN float ccAbs(float x) {
  return x < 0.0f ? -x : x;
}
CC_FN float ccMin(float a, float b) {
  return a < b ? a : b;
}
CC_FN float ccMax(float a, float b) {
  return a > b ? a : b;
}

CC_FN float ccDot(const float* a, const float* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

CC_FN void ccCross(const float* a, const float* b, float* out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

// Scales to length 1 and returns the length before; a zero vector stays.
CC_FN float ccNormalize(float* a) {
  const float length = CC_SQRT(ccDot(a, a));
  if (length > 0.0f) {
    a[0] /= length;
    a[1] /= length;
    a[2] /= length;
  }
  return length;
}

// Two unit tangents of a unit normal. The first is normal to the axis of its smallest component.
CC_FN void ccTangents(const float* n, float* t1, float* t2) {
  const float x = ccAbs(n[0]), y = ccAbs(n[1]), z = ccAbs(n[2]);
  float axis[3] = {0.0f, 0.0f, 0.0f};
  axis[x <= y && x <= z ? 0 : (y <= z ? 1 : 2)] = 1.0f;
  ccCross(n, axis, t1);
  ccNormalize(t1);
  ccCross(n, t1, t2);
}
