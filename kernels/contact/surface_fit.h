// Fits a surface to the coverage of a window of voxels (docs/engine.md, "Depth from the window").
// Voxel units, origin at the center of the window's middle voxel. Plain C for C++ and OpenCL C.
//
// The fit starts from the paper's base vector (4), from the center of mass Gc of the material in
// the window to the representative point Gr. Its direction is right to 0.4-3 deg, but its length is
// a poor measure of depth. Gauss-Newton then fits a small quadric that reproduces the coverage of
// every voxel (plane_cell.h). Errors: 0.001 voxel and 0.05 deg on planes, 0.0014 voxel and 0.08 deg
// on spheres of radius 10. The residual shows edges: 0.001 on smooth surfaces, above 0.003
// within 1.5 voxels of an edge of 10 deg, above 0.03 near one of 90 deg. Windows larger than 3x3x3
// are twice as exact on planes, but see edges from farther away and cost five times as much.
#ifndef CLOUDCONTACT_KERNELS_SURFACE_FIT_H
#define CLOUDCONTACT_KERNELS_SURFACE_FIT_H

#include "kernels/base/plane_cell.h"

#define CC_WINDOW_VOXELS 27     // 3x3x3, x fastest
#define CC_WINDOW_RADIUS2 3.3f  // square of the window's radius; the block's corners are inside
#define CC_FIT_ROUNDS 4         // 3 leave 0.004 on spheres of 10 voxels

// Material where n.x + (k11 u^2 + 2 k12 u v + k22 v^2)/2 < s, u and v along t1 and t2.
typedef struct {
  float n[3], t1[3], t2[3];
  float s;
  float k11, k12, k22;
  float residual;  // root mean square error of coverage over the voxels near the surface
  float weight;    // of these voxels; 0: no surface here
} CcSurface;

// The paper's base vector (4) of the block with the weight (1 - r^2/R^2)^2: Gr - Gc, where Gr is
// the middle. *fraction: share of material in the window.
CC_FN void ccBaseVector(const float* coverage, float* base, float* fraction) {
  float sum[3] = {0.0f, 0.0f, 0.0f}, mass = 0.0f, all = 0.0f;
  for (int k = 0; k < CC_WINDOW_VOXELS; ++k) {
    const float x = (float)(k % 3 - 1), y = (float)(k / 3 % 3 - 1), z = (float)(k / 9 - 1);
    const float q = 1.0f - (x * x + y * y + z * z) / CC_WINDOW_RADIUS2;
    const float w = q * q;
    all += w;
    mass += w * coverage[k];
    sum[0] -= w * coverage[k] * x;
    sum[1] -= w * coverage[k] * y;
    sum[2] -= w * coverage[k] * z;
  }
  for (int i = 0; i < 3; ++i) base[i] = mass > 0.0f ? sum[i] / mass : 0.0f;
  *fraction = mass / all;
}

// The coverage that a surface gives the voxel at x, and its derivative with respect to s.
CC_FN CcCut ccPredict(const CcSurface* f, const float* x) {
  const float u = ccDot(f->t1, x), v = ccDot(f->t2, x);
  const float ku = f->k11 * u + f->k12 * v, kv = f->k12 * u + f->k22 * v;
  // (k11 + k22)/24: the mean of the quadric over a voxel's own width (variance 1/12 each way).
  const float phi =
      ccDot(f->n, x) - f->s + 0.5f * (ku * u + kv * v) + (f->k11 + f->k22) * (1.0f / 24.0f);
  float m[3];
  for (int i = 0; i < 3; ++i) m[i] = f->n[i] + ku * f->t1[i] + kv * f->t2[i];
  const float length = CC_SQRT(ccDot(m, m)), by = length > 0.0f ? length : 1.0f;
  CcCut cut = ccCutCube(m[0] / by, m[1] / by, m[2] / by, -phi / length);
  cut.area /= length;
  return cut;
}

// Solves the symmetric 6x6 system a x = b in place by Cholesky; returns 0 if it is not definite.
CC_FN int ccSolve6(float* a, float* b) {
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) {
      float sum = a[i * 6 + j];
      for (int k = 0; k < j; ++k) sum -= a[i * 6 + k] * a[j * 6 + k];
      if (i == j) {
        if (sum <= 1e-9f) return 0;
        a[i * 6 + i] = CC_SQRT(sum);
      } else {
        a[i * 6 + j] = sum / a[j * 6 + j];
      }
    }
  }
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < i; ++k) b[i] -= a[i * 6 + k] * b[k];
    b[i] /= a[i * 6 + i];
  }
  for (int i = 5; i >= 0; --i) {
    for (int k = i + 1; k < 6; ++k) b[i] -= a[k * 6 + i] * b[k];
    b[i] /= a[i * 6 + i];
  }
  return 1;
}

// ccPredict() for all voxels of the window and a few more that fill the last vector register.
#define CC_WINDOW_LANES 32
CC_FN void ccPredictWindow(const CcSurface* f, float* volume, float* area) {
  for (int k = 0; k < CC_WINDOW_LANES; ++k) {
    const float x[3] = {(float)(k % 3 - 1), (float)(k / 3 % 3 - 1), (float)(k / 9 - 1)};
    const CcCut cut = ccPredict(f, x);
    volume[k] = cut.volume;
    area[k] = cut.area;
  }
}

// One Gauss-Newton round. `planar` holds the curvatures at zero.
CC_FN int ccFitRound(const float* coverage, int planar, CcSurface* f) {
  float a[36], b[6], square = 0.0f, weight = 0.0f;
  for (int i = 0; i < 36; ++i) a[i] = 0.0f;
  for (int i = 0; i < 6; ++i) b[i] = 0.0f;
  float volume[CC_WINDOW_LANES], area[CC_WINDOW_LANES];
  ccPredictWindow(f, volume, area);
  for (int k = 0; k < CC_WINDOW_VOXELS; ++k) {
    const float x[3] = {(float)(k % 3 - 1), (float)(k / 3 % 3 - 1), (float)(k / 9 - 1)};
    const float q = 1.0f - ccDot(x, x) / CC_WINDOW_RADIUS2;
    const CcCut cut = {volume[k], area[k]};
    const float r = coverage[k] - cut.volume;
    if (cut.area == 0.0f && ccAbs(r) < 2e-3f) continue;
    const float w = q * q;
    square += w * r * r;
    weight += w;
    const float u = ccDot(f->t1, x), v = ccDot(f->t2, x);
    // A voxel that the surface has just left still pulls it back. Without this, faces along the
    // grid stick to voxel faces, 0.04 from where they are.
    const float pull = cut.area == 0.0f ? 0.5f : cut.area;
    float g[6] = {pull, -pull * u, -pull * v, 0.0f, 0.0f, 0.0f};
    if (!planar) {
      g[3] = -0.5f * pull * (u * u + 1.0f / 12.0f);
      g[4] = -pull * u * v;
      g[5] = -0.5f * pull * (v * v + 1.0f / 12.0f);
    }
    for (int i = 0; i < 6; ++i) {
      b[i] += w * g[i] * r;
      for (int j = 0; j <= i; ++j) a[i * 6 + j] += w * g[i] * g[j];
    }
  }
  f->weight = weight;
  f->residual = weight > 0.0f ? CC_SQRT(square / weight) : 1.0f;
  // A small ridge: a window that shows too little gets no tilt and no curvature.
  const float ridge[6] = {1e-5f, 1e-4f, 1e-4f, 1e-3f, 1e-3f, 1e-3f};
  for (int i = 0; i < 6; ++i) a[i * 6 + i] += ridge[i] + (planar && i > 2 ? 1.0f : 0.0f);
  b[3] -= ridge[3] * f->k11;
  b[4] -= ridge[4] * f->k12;
  b[5] -= ridge[5] * f->k22;
  if (!ccSolve6(a, b)) return 0;
  const float largest = ccMax(ccMax(ccAbs(b[1]), ccAbs(b[2])), 0.5f * ccAbs(b[0]));
  const float step = largest > 0.5f ? 0.5f / largest : 1.0f;  // no round turns by more than 27 deg
  f->s += step * b[0];
  f->k11 += step * b[3];
  f->k12 += step * b[4];
  f->k22 += step * b[5];
  for (int i = 0; i < 3; ++i) f->n[i] += step * (b[1] * f->t1[i] + b[2] * f->t2[i]);
  const float length = ccNormalize(f->n);
  f->s /= length;
  // Project the tangents, so that the curvatures keep their meaning.
  const float lean = ccDot(f->t1, f->n);
  for (int i = 0; i < 3; ++i) f->t1[i] -= lean * f->n[i];
  ccNormalize(f->t1);
  ccCross(f->n, f->t1, f->t2);
  return 1;
}

// Fits a surface to the 3x3x3 block; `coverage` in 0..1, x fastest. weight 0: there is none.
CC_FN CcSurface ccFitSurface(const float* coverage, int planar) {
  CcSurface f;
  float fraction;
  ccBaseVector(coverage, f.n, &fraction);
  f.k11 = f.k12 = f.k22 = 0.0f;
  f.weight = 0.0f;
  f.residual = 1.0f;
  f.s = (fraction - 0.5f) * 1.8f;
  if (ccNormalize(f.n) < 1e-6f) {
    f.s = 0.0f;
    return f;
  }
  ccTangents(f.n, f.t1, f.t2);
  for (int round = 0; round < CC_FIT_ROUNDS; ++round) {
    if (!ccFitRound(coverage, planar, &f)) break;
  }
  // The residual of the final surface, not of the round before.
  float square = 0.0f, weight = 0.0f, volume[CC_WINDOW_LANES], area[CC_WINDOW_LANES];
  ccPredictWindow(&f, volume, area);
  for (int k = 0; k < CC_WINDOW_VOXELS; ++k) {
    const float x[3] = {(float)(k % 3 - 1), (float)(k / 3 % 3 - 1), (float)(k / 9 - 1)};
    const float q = 1.0f - ccDot(x, x) / CC_WINDOW_RADIUS2;
    const CcCut cut = {volume[k], area[k]};
    const float r = coverage[k] - cut.volume;
    if (cut.area == 0.0f && ccAbs(r) < 2e-3f) continue;
    square += q * q * r * r;
    weight += q * q;
  }
  f.weight = weight;
  f.residual = weight > 0.0f ? CC_SQRT(square / weight) : 1.0f;
  return f;
}

#endif
