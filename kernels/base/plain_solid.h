// Plain solids: how deep a point lies in one, and the outward normal of its nearest surface.
// Lengths in meters, in the solid's own frame, centered on the origin, the axis along z. Plain C
// for C++ and OpenCL C; cloudcontact/law/solid.h says what each is.
//
// Bodies of revolution are solved in the half-plane (r, z) through their axis. A point on an axis
// or at a center is equally near to many surface points, and any of them is right.
#pragma once

#include "kernels/base/vector64.h"

#define CC_HALF_SPACE 0
#define CC_SPHERE 1
#define CC_BOX 2
#define CC_ELLIPSOID 3
#define CC_CAPSULE 4
#define CC_CYLINDER 5
#define CC_CONE 6

// Its numbers, in this order: normal and offset; radius; half extents; semi-axes; radius and half
// height of a capsule, of a cylinder, and, with the margin, of a cone.
typedef struct {
  int kind;
  int edged;  // it has edges or a tip
  double size[4];
} CcSolid;

typedef struct {
  double depth;  // negative outside
  CcVec normal;
} CcSolidPoint;

CC_FN CcSolidPoint ccSolidPoint(double depth, CcVec normal) {
  const CcSolidPoint p = {depth, normal};
  return p;
}
CC_FN CcVec ccPart(CcVec a, double length) {
  return ccVec(a.x / length, a.y / length, a.z / length);
}
// The unit vector along `v`, or `other` where v is zero.
CC_FN CcVec ccDirectionOr(CcVec v, CcVec other) {
  const double length = ccLength64(v);
  return length > 0.0 ? ccPart(v, length) : other;
}

CC_FN CcSolidPoint ccInHalfSpace(CcVec normal, double offset, CcVec x) {
  return ccSolidPoint(offset - ccDot64(normal, x), normal);
}
CC_FN CcSolidPoint ccInSphere(double radius, CcVec x) {
  return ccSolidPoint(radius - ccLength64(x), ccDirectionOr(x, ccVec(0.0, 0.0, 1.0)));
}
CC_FN CcSolidPoint ccInCapsule(double radius, double halfHeight, CcVec x) {
  const CcVec out = ccVec(x.x, x.y, x.z - ccClamp64(x.z, -halfHeight, halfHeight));
  return ccSolidPoint(radius - ccLength64(out), ccDirectionOr(out, ccVec(1.0, 0.0, 0.0)));
}

CC_FN CcSolidPoint ccInBox(CcVec extents, CcVec x) {
  const CcVec side = ccVec(x.x < 0.0 ? -1.0 : 1.0, x.y < 0.0 ? -1.0 : 1.0, x.z < 0.0 ? -1.0 : 1.0);
  const CcVec beyond =
      ccVec(ccAbs64(x.x) - extents.x, ccAbs64(x.y) - extents.y, ccAbs64(x.z) - extents.z);
  const double most = ccMax64(ccMax64(beyond.x, beyond.y), beyond.z);
  if (most <= 0.0) {
    const int isX = beyond.x == most, isY = !isX && beyond.y == most;
    return ccSolidPoint(-most,
                        ccVec(isX ? side.x : 0.0, isY ? side.y : 0.0, !isX && !isY ? side.z : 0.0));
  }
  const CcVec out = ccVec(side.x * ccMax64(beyond.x, 0.0), side.y * ccMax64(beyond.y, 0.0),
                          side.z * ccMax64(beyond.z, 0.0));
  const double distance = ccLength64(out);
  return ccSolidPoint(-distance, ccPart(out, distance));
}

// The implicit function over its gradient: first order in the distance from the surface.
CC_FN CcSolidPoint ccInEllipsoid(CcVec axes, CcVec x) {
  const CcVec one = ccVec(x.x / axes.x, x.y / axes.y, x.z / axes.z);
  const CcVec up = ccVec(x.x / (axes.x * axes.x), x.y / (axes.y * axes.y), x.z / (axes.z * axes.z));
  const CcVec normal = ccDirectionOr(up, ccVec(0.0, 0.0, 1.0));
  const double r = ccLength64(one), least = ccMin64(ccMin64(axes.x, axes.y), axes.z);
  // At the center every direction is a ray; the shortest way out is along the least axis.
  if (r < 1e-12) return ccSolidPoint(least, normal);
  return ccSolidPoint(ccMin64((1.0 - r) / (ccLength64(up) / r), least), normal);
}

// A point of the half-plane: r along the unit vector `radial`, and z.
typedef struct {
  double r, z;
  CcVec radial;
} CcProfile;

CC_FN CcProfile ccProfileOf(CcVec x) {
  const double r = ccSqrt64(x.x * x.x + x.y * x.y);
  const CcProfile p = {r, x.z, ccDirectionOr(ccVec(x.x, x.y, 0.0), ccVec(1.0, 0.0, 0.0))};
  return p;
}
CC_FN CcVec ccLift(CcVec radial, double r, double z) {
  return ccVec(r * radial.x, r * radial.y, r * radial.z + z);
}

CC_FN CcSolidPoint ccInCylinder(double radius, double halfHeight, CcVec x) {
  const CcProfile p = ccProfileOf(x);
  const double side = p.z < 0.0 ? -1.0 : 1.0;
  const double out = p.r - radius, up = ccAbs64(p.z) - halfHeight;
  if (ccMax64(out, up) <= 0.0)
    return out >= up ? ccSolidPoint(-out, p.radial) : ccSolidPoint(-up, ccVec(0.0, 0.0, side));
  const double r = ccMax64(out, 0.0), z = ccMax64(up, 0.0), distance = ccSqrt64(r * r + z * z);
  return ccSolidPoint(-distance, ccLift(p.radial, r / distance, side * z / distance));
}

// From the nearest point of the segment from a to b, by (r, z), to x.
CC_FN CcTwo ccFromSegment(CcTwo a, CcTwo b, CcTwo x) {
  const CcTwo along = ccTwo(b.u - a.u, b.v - a.v);
  const double t =
      ((x.u - a.u) * along.u + (x.v - a.v) * along.v) / (along.u * along.u + along.v * along.v);
  const double part = ccClamp64(t, 0.0, 1.0);
  return ccTwo(x.u - (a.u + part * along.u), x.v - (a.v + part * along.v));
}

// A margin moves every surface point out along its normal: it adds to the depth and turns nothing.
CC_FN CcSolidPoint ccInCone(double radius, double halfHeight, double margin, CcVec x) {
  const CcProfile p = ccProfileOf(x);
  const CcTwo rim = ccTwo(radius, -halfHeight), tip = ccTwo(0.0, halfHeight), at = ccTwo(p.r, p.z);
  const double length = ccSqrt64(4.0 * halfHeight * halfHeight + radius * radius);
  const CcTwo slope = ccTwo(2.0 * halfHeight / length, radius / length);
  const double above = slope.u * p.r + slope.v * (p.z - halfHeight), below = -halfHeight - p.z;
  if (above <= 0.0 && below <= 0.0)
    return above >= below ? ccSolidPoint(margin - above, ccLift(p.radial, slope.u, slope.v))
                          : ccSolidPoint(margin - below, ccVec(0.0, 0.0, -1.0));
  const CcTwo fromSlope = ccFromSegment(tip, rim, at),
              fromBase = ccFromSegment(ccTwo(0.0, -halfHeight), rim, at);
  const double toSlope = fromSlope.u * fromSlope.u + fromSlope.v * fromSlope.v,
               toBase = fromBase.u * fromBase.u + fromBase.v * fromBase.v;
  const CcTwo out = toSlope < toBase ? fromSlope : fromBase;
  const double distance = ccSqrt64(ccMin64(toSlope, toBase));
  return ccSolidPoint(margin - distance, ccLift(p.radial, out.u / distance, out.v / distance));
}

CC_FN CcSolidPoint ccInSolid(CC_GLOBAL const CcSolid* s, CcVec x) {
  const double a = s->size[0], b = s->size[1], c = s->size[2];
  switch (s->kind) {
    case CC_SPHERE:
      return ccInSphere(a, x);
    case CC_BOX:
      return ccInBox(ccVec(a, b, c), x);
    case CC_ELLIPSOID:
      return ccInEllipsoid(ccVec(a, b, c), x);
    case CC_CAPSULE:
      return ccInCapsule(a, b, x);
    case CC_CYLINDER:
      return ccInCylinder(a, b, x);
    case CC_CONE:
      return ccInCone(a, b, c, x);
    default:
      return ccInHalfSpace(ccVec(a, b, c), s->size[3], x);
  }
}
