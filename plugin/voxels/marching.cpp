// The 256 cases, derived by rule. On each face of the cube the surface leaves lines between crossed
// edges, with the inside to their right seen from outside the cube. The lines connect to loops.
#include "voxels/marching.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace cloudcontact {

namespace {

// Edge between two corners that differ in one axis.
int edgeBetween(int a, int b) {
  const int axis = std::countr_zero(static_cast<unsigned>(a ^ b)), low = std::min(a, b);
  const int below = low & ((1 << axis) - 1), above = low >> (axis + 1) << axis;
  return 4 * axis + (below | above);
}

// The corners of a face, counter-clockwise seen from outside the cube.
std::array<int, 4> cornersOf(int face) {
  const int axis = face >> 1, side = face & 1;
  const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, base = side << axis;
  if (side) return {base, base | u, base | u | v, base | v};
  return {base, base | v, base | u | v, base | u};
}

// For each crossed edge the next one along the loop. Each run of inside corners around a face is
// cut off by a line of its own, so two opposite inside corners are separated.
std::array<int, kCubeEdges> linesOf(int inside) {
  std::array<int, kCubeEdges> next;
  next.fill(-1);
  const auto in = [inside](int corner) { return (inside >> corner & 1) != 0; };
  for (int face = 0; face < 6; ++face) {
    const std::array<int, 4> c = cornersOf(face);
    const auto at = [&c](int i) { return c[i & 3]; };
    for (int first = 0; first < 4; ++first) {
      if (!in(at(first)) || in(at(first + 3))) continue;
      int last = first;
      while (in(at(last + 1))) ++last;
      const int from = edgeBetween(at(first + 3), at(first));
      next[from] = edgeBetween(at(last), at(last + 1));
    }
  }
  return next;
}

bool shareAFace(int a, int b) {
  for (int axis = 0; axis < 3; ++axis) {
    if (a / 4 == axis || b / 4 == axis) continue;
    if ((edgeStart(a) >> axis & 1) == (edgeStart(b) >> axis & 1)) return true;
  }
  return false;
}

// Triangulates a loop as a fan. Its apex must have no diagonal in a face of the cube: the
// neighboring cube could have the same diagonal, and four triangles would share it. Without such a
// corner the apex is the middle.
void triangulate(CubeLoop& loop) {
  const int n = static_cast<int>(loop.edges.size());
  const auto edge = [&](int i) { return loop.edges[i % n]; };
  for (int apex = 0; apex < n; ++apex) {
    bool good = true;
    for (int i = 2; i <= n - 2; ++i) good = good && !shareAFace(edge(apex), edge(apex + i));
    if (!good) continue;
    for (int i = 1; i + 1 < n; ++i)
      loop.triangles.push_back({apex, (apex + i) % n, (apex + i + 1) % n});
    return;
  }
  loop.middle = true;
  for (int i = 0; i < n; ++i) loop.triangles.push_back({n, i, (i + 1) % n});
}

std::vector<CubeLoop> loopsOf(int inside) {
  std::array<int, kCubeEdges> next = linesOf(inside);
  std::vector<CubeLoop> loops;
  for (int first = 0; first < kCubeEdges; ++first) {
    CubeLoop loop;
    for (int e = first; next[e] >= 0;) {
      loop.edges.push_back(e);
      e = std::exchange(next[e], -1);
    }
    if (loop.edges.empty()) continue;
    triangulate(loop);
    loops.push_back(std::move(loop));
  }
  return loops;
}

}  // namespace

int edgeStart(int edge) {
  const int axis = edge / 4, i = edge & 3;
  const int below = i & ((1 << axis) - 1);
  return below | (i - below) << 1;
}

const std::vector<CubeLoop>& cubeLoops(int inside) {
  static const auto kAll = [] {
    std::array<std::vector<CubeLoop>, 256> all;
    for (int k = 0; k < 256; ++k) all[k] = loopsOf(k);
    return all;
  }();
  return kAll[inside];
}

}  // namespace cloudcontact
