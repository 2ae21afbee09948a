// A plane that cuts a unit cube: the volume below it and the area of the cut, in closed form. Plain
// C for C++ and OpenCL C.
//
// The closed form is that of the volume of fluid method (Scardovelli and Zaleski, J. Comput. Phys.
// 164, 2000). With the sizes of the normal's components scaled so that m1 <= m2 <= m3 add up to 1,
// the volume is a piecewise cubic in the plane's offset, symmetric about the middle.
#pragma once

#include "kernels/base/vector.h"

// Smallest scaled normal component. Below it the cubic pieces cancel in float (an error of the
// volume of 1e-4 at 1e-3), so the plane is turned about the cube's center by less than 0.06 deg.
#define CC_MIN_COMPONENT 1e-3f

typedef struct {
  float volume;  // of the cube that lies below the plane, 0..1
  float area;    // of the plane inside the cube, 0..sqrt(3)
} CcCut;

// The lower half of the cubic, alpha in [0, 1/2]. Returns the volume, and its slope in *slope. It
// computes all pieces and selects one, so that a loop over voxels has no branches and vectorizes.
CC_FN float ccCubic(float m1, float m2, float m3, float alpha, float* slope) {
  const float m12 = m1 + m2;
  const float d = 1.0f / (6.0f * m1 * m2 * m3), e = 1.0f / (2.0f * m2 * m3);
  // Written with (alpha - m)^3 so that nothing large cancels.
  const float a1 = alpha - m1, a2 = alpha - m2, a3 = ccMax(alpha - m3, 0.0f);
  const float square = alpha * alpha, cube = alpha * alpha * alpha;
  const int first = alpha < m1, second = alpha < m2, flat = (alpha >= m12) & (m12 <= m3);
  float s = 3.0f * (square - a1 * a1 - a2 * a2 - a3 * a3) * d;
  float v = (cube - a1 * a1 * a1 - a2 * a2 * a2 - a3 * a3 * a3) * d;
  s = flat ? 1.0f / m3 : s;
  v = flat ? (2.0f * alpha - m12) / (2.0f * m3) : v;
  s = second ? (2.0f * alpha - m1) * e : s;
  v = second ? (alpha * (alpha - m1) + m1 * m1 * (1.0f / 3.0f)) * e : v;
  s = first ? 3.0f * alpha * alpha * d : s;
  v = first ? cube * d : v;
  *slope = s;
  return v;
}

// The cube [-1/2,1/2]^3 cut by normal . x < offset; (nx, ny, nz) has length 1.
CC_FN CcCut ccCutCube(float nx, float ny, float nz, float offset) {
  CcCut cut;
  const float x = ccAbs(nx), y = ccAbs(ny), z = ccAbs(nz);
  const float low = ccMin(x, y), high = ccMax(x, y), between = ccMin(high, z);
  const float a = ccMin(low, between), b = ccMax(low, between), c = ccMax(high, z);
  const float sum = a + b + c;
  const float scale = 1.0f / sum;
  const float m1 = ccMax(a * scale, CC_MIN_COMPONENT), m2 = ccMax(b * scale, CC_MIN_COMPONENT);
  const float m3 = 1.0f - m1 - m2;
  const float alpha = 0.5f + offset * scale;
  const int none = alpha <= 0.0f, all = alpha >= 1.0f, lower = alpha <= 0.5f;
  float slope;
  const float part = ccCubic(m1, m2, m3, lower ? alpha : 1.0f - alpha, &slope);
  const float some = lower ? part : 1.0f - part;
  cut.volume = none ? 0.0f : (all ? 1.0f : some);
  cut.area = (none | all) ? 0.0f : slope * scale;
  return cut;
}
