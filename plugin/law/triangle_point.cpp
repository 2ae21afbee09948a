// By the Voronoi regions of the triangle's features.
#include "law/triangle_point.h"

namespace cloudcontact {

int nearestOnTriangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& x, Vec3& foot) {
  const Vec3 ab = b - a, ac = c - a, ax = x - a;
  const double d1 = ab.dot(ax), d2 = ac.dot(ax);
  if (d1 <= 0 && d2 <= 0) return foot = a, 1;
  const Vec3 bx = x - b;
  const double d3 = ab.dot(bx), d4 = ac.dot(bx);
  if (d3 >= 0 && d4 <= d3) return foot = b, 2;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return foot = a + d1 / (d1 - d3) * ab, 4;
  const Vec3 cx = x - c;
  const double d5 = ab.dot(cx), d6 = ac.dot(cx);
  if (d6 >= 0 && d5 <= d6) return foot = c, 3;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return foot = a + d2 / (d2 - d6) * ac, 6;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6)
    return foot = b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b), 5;
  const double all = 1 / (va + vb + vc);
  return foot = a + vb * all * ab + vc * all * ac, 0;
}

}  // namespace cloudcontact
