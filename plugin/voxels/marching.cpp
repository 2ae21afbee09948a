// The cases by rule. On each face of the cube the surface leaves lines between crossed edges, with
// the inside to their right as seen from outside the cube; from line to line they close to loops.
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

// For each crossed edge the one that the surface's line on some face leads to from it. A run of
// inside corners around a face is cut off by one line, from the edge where it ends to the edge
// where it begins; of two runs each by its own, which parts opposite corners.
std::array<int, kCubeEdges> linesOf(int inside) {
  std::array<int, kCubeEdges> next;
  next.fill(-1);
  const auto in = [inside](int corner) { return (inside >> corner & 1) != 0; };
  for (int face = 0; face < 6; ++face) {
    const std::array<int, 4> c = cornersOf(face);
    const auto at = [&c](int i) { return c[static_cast<std::size_t>(i & 3)]; };
    for (int first = 0; first < 4; ++first) {
      if (!in(at(first)) || in(at(first + 3))) continue;
      int last = first;
      while (in(at(last + 1))) ++last;
      const int from = edgeBetween(at(first + 3), at(first));
      next[static_cast<std::size_t>(from)] = edgeBetween(at(last), at(last + 1));
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

// A fan, from a corner none of whose diagonals runs in a face of the cube: the cube beside might
// have the same one there, and four triangles would meet in it. Where there is no such corner, from
// the middle.
void triangulate(CubeLoop& loop) {
  const int n = static_cast<int>(loop.edges.size());
  const auto edge = [&](int i) { return loop.edges[static_cast<std::size_t>(i % n)]; };
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
    for (int e = first; next[static_cast<std::size_t>(e)] >= 0;) {
      loop.edges.push_back(e);
      e = std::exchange(next[static_cast<std::size_t>(e)], -1);
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
    for (int k = 0; k < 256; ++k) all[static_cast<std::size_t>(k)] = loopsOf(k);
    return all;
  }();
  return kAll[static_cast<std::size_t>(inside)];
}

}  // namespace cloudcontact
