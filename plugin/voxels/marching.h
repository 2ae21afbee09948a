// The 256 cases of marching cubes: triangles over the edges of a cube whose corners are inside or
// outside. The table is computed on first use.
#pragma once

#include <array>
#include <vector>

namespace cloudcontact {

// Corner c lies at (c & 1, c >> 1 & 1, c >> 2). Edge 4 a + i runs along axis a from the i-th corner
// (in ascending order) that lies at 0 of that axis.
constexpr int kCubeEdges = 12;
int edgeStart(int edge);  // the edge's corner at 0 of its axis

// A closed line in which the surface crosses the cube's faces, as the edges that it crosses,
// counter-clockwise seen from outside.
struct CubeLoop {
  std::vector<int> edges;
  // Triangles of indices into `edges`. With `middle`, index edges.size() is the mean of all edges.
  std::vector<std::array<int, 3>> triangles;
  bool middle = false;
};

// The loops of a case. Bit c of `inside`: corner c is inside. Two diagonally opposite inside
// corners of a face are separated on it, in this cube and in its neighbor, so the surface is closed
// with two triangles at each edge.
const std::vector<CubeLoop>& cubeLoops(int inside);

}  // namespace cloudcontact
