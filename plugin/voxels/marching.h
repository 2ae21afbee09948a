// How a surface runs through a cube whose corners are inside or outside: triangles over the cube's
// edges, for each of the 256 cases. Worked out when first asked for, not written down.
#pragma once

#include <array>
#include <vector>

namespace cloudcontact {

// Corner c lies at (c & 1, c >> 1 & 1, c >> 2). Edge 4 a + i runs along axis a from the i-th corner
// (in rising order) that lies at 0 of that axis.
constexpr int kCubeEdges = 12;
int edgeStart(int edge);  // the edge's corner at 0 of its axis

// One closed line in which the surface cuts the cube's faces, by the edges that it crosses,
// counter- clockwise seen from outside.
struct CubeLoop {
  std::vector<int> edges;
  // Triangles of places in `edges`; where `middle`, place edges.size() is the mean of all.
  std::vector<std::array<int, 3>> triangles;
  bool middle = false;
};

// Bit c of `inside`: corner c is. Two opposite inside corners of a face are parted there, in this
// cube and in the one beside it alike: so the surface is closed, each of its edges in two
// triangles.
const std::vector<CubeLoop>& cubeLoops(int inside);

}  // namespace cloudcontact
