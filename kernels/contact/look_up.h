// The place of a point of one body in the records of another body's field. Plain C for C++ and
// OpenCL C.
#ifndef CLOUDCONTACT_KERNELS_LOOK_UP_H
#define CLOUDCONTACT_KERNELS_LOOK_UP_H

#include "kernels/base/vector.h"

// A rigid map with a scale, x -> turn x + shift; `turn` by rows.
typedef struct {
  float turn[9];
  float shift[3];
} CcMap;

CC_FN void ccTurn(CC_NEAR const float* turn, const float* v, float* out) {
  out[0] = turn[0] * v[0] + turn[1] * v[1] + turn[2] * v[2];
  out[1] = turn[3] * v[0] + turn[4] * v[1] + turn[5] * v[2];
  out[2] = turn[6] * v[0] + turn[7] * v[1] + turn[8] * v[2];
}

// The transposed matrix times v.
CC_FN void ccTurnBack(CC_NEAR const float* turn, const float* v, float* out) {
  out[0] = turn[0] * v[0] + turn[3] * v[1] + turn[6] * v[2];
  out[1] = turn[1] * v[0] + turn[4] * v[1] + turn[7] * v[2];
  out[2] = turn[2] * v[0] + turn[5] * v[1] + turn[8] * v[2];
}

CC_FN void ccApply(CC_NEAR const CcMap* map, const float* x, float* out) {
  ccTurn(map->turn, x, out);
  out[0] += map->shift[0];
  out[1] += map->shift[1];
  out[2] += map->shift[2];
}

// The maps of one body's samples into the other body and into the pair's frame.
typedef struct {
  CcMap toFrame;            // samples' grid -> frame body, meters
  float frameFromOwn[9];    // turns the samples' normals into the frame
  float frameFromOther[9];  // turns the other body's normals into the frame
  float turnToOther[9];     // turns the samples' normals into the other body's frame
  CcMap toOther;            // samples' grid -> other's grid, voxels; unused for a shape
} CcWay;

// A grid of bricks of 8x8x8 voxels. A point outside has the brick number nx * ny * nz.
typedef struct {
  int nx, ny, nz;
} CcBricks;

typedef struct {
  int brick;   // its number, x fastest
  int cell;    // of the voxel in its brick, x fastest
  float r[3];  // the point from the voxel's center, voxels
} CcPlace;

CC_FN CcPlace ccPlaceOf(CcBricks bricks, const float* x) {
  CcPlace p;
  const int inside = (x[0] >= 0.0f) & (x[1] >= 0.0f) & (x[2] >= 0.0f) &
                     (x[0] < (float)(8 * bricks.nx)) & (x[1] < (float)(8 * bricks.ny)) &
                     (x[2] < (float)(8 * bricks.nz));
  // Inside the grid a cast is a floor; outside it might overflow.
  const float u = inside ? x[0] : 0.0f, v = inside ? x[1] : 0.0f, w = inside ? x[2] : 0.0f;
  const int i = (int)u, j = (int)v, k = (int)w;
  const int brick = (i >> 3) + bricks.nx * ((j >> 3) + bricks.ny * (k >> 3));
  p.brick = inside ? brick : bricks.nx * bricks.ny * bricks.nz;
  p.cell = (i & 7) | ((j & 7) << 3) | ((k & 7) << 6);
  p.r[0] = u - (float)i - 0.5f;
  p.r[1] = v - (float)j - 0.5f;
  p.r[2] = w - (float)k - 0.5f;
  return p;
}

// The distance of a point from the grid, and the brick nearest to it.
CC_FN float ccAwayFrom(CcBricks bricks, const float* x, int* brick) {
  const float u = ccMax(ccMin(x[0], (float)(8 * bricks.nx) - 0.5f), 0.0f),
              v = ccMax(ccMin(x[1], (float)(8 * bricks.ny) - 0.5f), 0.0f),
              w = ccMax(ccMin(x[2], (float)(8 * bricks.nz) - 0.5f), 0.0f);
  const float d[3] = {x[0] - u, x[1] - v, x[2] - w};
  *brick = ((int)u >> 3) + bricks.nx * (((int)v >> 3) + bricks.ny * ((int)w >> 3));
  return CC_SQRT(ccDot(d, d));
}

#endif
