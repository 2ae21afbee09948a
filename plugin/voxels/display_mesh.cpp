// Marching cubes (Lorensen and Cline 1987) between the centers of voxels; cubeLoops() resolves
// the ambiguous faces. Surface nets and dual contouring would give fewer triangles. But after cuts,
// voxels meet at edges and corners, and there both produce edges with four triangles.
//
// A vertex lies between two centers. Its position follows from the sum of both coverages, which is
// exact for planes that cross both voxels from side to side, and from linear interpolation where
// the plane runs along the edge.
//
// Cube (x, y, z) lies between the centers of voxels (x - 1, y - 1, z - 1) and (x, y, z). So there
// is one row of cubes more than of voxels, for bodies that touch the border of the grid. A brick of
// cubes reads the voxels of the cloud's brick at the same place, and one layer of those before it.
#include <cloudcontact/voxels/display_mesh.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "base/grid_index.h"
#include "base/parallel.h"
#include "voxels/cut_between.h"

namespace cloudcontact {

namespace {

constexpr int kHalf = 128;             // least coverage of a voxel whose center is inside
constexpr int kSide = kBrickEdge + 1;  // voxels that a brick of cubes reads along an axis

// The 256 cases of marching cubes are derived by rule. On each face of the cube the surface leaves
// lines between crossed edges, with the inside to their right seen from outside the cube. The lines
// connect to loops.
//
// Corner c lies at (c & 1, c >> 1 & 1, c >> 2). Edge 4 a + i runs along axis a from the i-th corner
// (in ascending order) that lies at 0 of that axis.
constexpr int kCubeEdges = 12;
// The edge's corner at 0 of its axis.
int edgeStart(int edge) {
  const int axis = edge / 4, i = edge & 3;
  const int below = i & ((1 << axis) - 1);
  return below | (i - below) << 1;
}

// A closed line in which the surface crosses the cube's faces, as the edges that it crosses,
// counter-clockwise seen from outside.
struct CubeLoop {
  std::vector<int> edges;
  // Triangles of indices into `edges`. With `middle`, index edges.size() is the mean of all edges.
  std::vector<std::array<int, 3>> triangles;
  bool middle = false;
};

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

// The loops of a case. Bit c of `inside`: corner c is inside. Two diagonally opposite inside
// corners of a face are separated on it, in this cube and in its neighbor, so the surface is closed
// with two triangles at each edge.
const std::vector<CubeLoop>& cubeLoops(int inside) {
  static const auto kAll = [] {
    std::array<std::vector<CubeLoop>, 256> all;
    for (int k = 0; k < 256; ++k) all[k] = loopsOf(k);
    return all;
  }();
  return kAll[inside];
}

Eigen::Vector3i cubeBricks(const Cloud& cloud) {
  return cloud.bricks() + Eigen::Vector3i::Constant(1);
}

// Whether the table shows all voxels that a brick of cubes reads to be equal.
bool uniform(const Cloud& cloud, const Eigen::Vector3i& place) {
  const Eigen::Vector3i n = cloud.bricks();
  int kind = 0;
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3i b = place - Eigen::Vector3i(k & 1, k >> 1 & 1, k >> 2);
    const int own = insideGrid(b, n) ? cloud.voxels().table[gridIndex(b, n)] : kEmptyBrick;
    if (own >= 0 || (k > 0 && own != kind)) return false;
    kind = own;
  }
  return true;
}

class BrickMesher {
 public:
  BrickMesher(const Cloud& cloud, const Eigen::Vector3i& place)
      : cloud_(cloud), low_(kBrickEdge * place - Eigen::Vector3i::Constant(1)) {
    for (int k = 0; k < kSide * kSide * kSide; ++k) {
      const Eigen::Vector3i v = low_ + at(k);
      coverage_[k] = cloud.coverage(v.x(), v.y(), v.z());
    }
    vertex_.fill(-1);
  }

  std::unique_ptr<const DisplayBrick> run() {
    for (int z = 0; z < kBrickEdge; ++z)
      for (int y = 0; y < kBrickEdge; ++y)
        for (int x = 0; x < kBrickEdge; ++x) cube(x + kSide * (y + kSide * z));
    if (brick_.triangles.empty()) return nullptr;
    return std::make_unique<const DisplayBrick>(std::move(brick_));
  }

 private:
  static Eigen::Vector3i at(int k) { return {k % kSide, k / kSide % kSide, k / kSide / kSide}; }
  static int step(int axis) { return axis == 0 ? 1 : axis == 1 ? kSide : kSide * kSide; }
  static int corner(int cube, int c) {
    return cube + (c & 1) + kSide * (c >> 1 & 1) + kSide * kSide * (c >> 2);
  }
  int coverage(int k) const { return coverage_[k]; }

  void cube(int first) {
    int inside = 0;
    for (int c = 0; c < 8; ++c) inside |= (coverage(corner(first, c)) >= kHalf) << c;
    if (inside == 0 || inside == 255) return;
    for (const CubeLoop& loop : cubeLoops(inside)) add(first, loop);
  }

  void add(int first, const CubeLoop& loop) {
    const int n = static_cast<int>(loop.edges.size());
    int ends[kCubeEdges + 1];
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (int i = 0; i < n; ++i) {
      const int edge = loop.edges[i];
      ends[i] = vertexOn(corner(first, edgeStart(edge)), edge / 4);
      sum += brick_.vertices[ends[i]];
    }
    if (loop.middle) {
      ends[n] = static_cast<int>(brick_.vertices.size());
      brick_.vertices.push_back(sum / float(n));
      insides_.push_back(insides_[ends[0]]);
    }
    for (const auto& t : loop.triangles) {
      const Eigen::Vector3i corners(ends[t[0]], ends[t[1]], ends[t[2]]);
      brick_.triangles.push_back(corners);
      brick_.materials.push_back(materialOf(corners));
    }
  }

  // The vertex between two centers, created on first use.
  int vertexOn(int from, int axis) {
    std::int16_t& known = vertex_[3 * from + axis];
    if (known >= 0) return known;
    const int to = from + step(axis);
    Eigen::Vector3f place = (low_ + at(from)).cast<float>() + Eigen::Vector3f::Constant(0.5f);
    const float a = float(coverage(from)) / 255, b = float(coverage(to)) / 255;
    const float beyond = (a + b - 1) * std::max(1.0f, 0.5f / std::abs(a - b));
    place[axis] += 0.5f + (a > b ? beyond : -beyond);
    known = static_cast<std::int16_t>(brick_.vertices.size());
    brick_.vertices.push_back(place);
    insides_.push_back(a > b ? from : to);
    return known;
  }

  // The majority of the voxels just inside the corners; the first one where all three differ.
  std::uint8_t materialOf(const Eigen::Vector3i& corners) const {
    if (cloud_.materials().empty()) return 0;
    std::uint8_t of[3];
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3i v = low_ + at(insides_[corners[i]]);
      of[i] = cloud_.material(v.x(), v.y(), v.z());
    }
    return of[1] == of[2] ? of[1] : of[0];
  }

  const Cloud& cloud_;
  Eigen::Vector3i low_;
  std::array<std::uint8_t, kSide * kSide * kSide> coverage_;
  std::array<std::int16_t, 3 * kSide * kSide * kSide> vertex_;
  std::vector<int> insides_;  // the voxel just inside each vertex
  DisplayBrick brick_;
};

// The bricks of cubes that read a voxel whose coverage or material changed.
std::vector<int> touched(const Cloud& before, const Cloud& after) {
  const Cloud::Voxels &a = before.voxels(), &b = after.voxels();
  const Eigen::Vector3i n = after.bricks(), cubes = cubeBricks(after);
  std::vector<char> marked(cubes.prod(), 0);
  for (std::size_t t = 0; t < a.table.size(); ++t) {
    if (sameCoverage(a, b, t) && sameMaterial(a, b, t)) continue;
    const Eigen::Vector3i place = gridCell(t, n);
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3i c = place + Eigen::Vector3i(k & 1, k >> 1 & 1, k >> 2);
      marked[gridIndex(c, cubes)] = 1;
    }
  }
  std::vector<int> numbers;
  for (std::size_t i = 0; i < marked.size(); ++i)
    if (marked[i]) numbers.push_back(static_cast<int>(i));
  return numbers;
}

}  // namespace

DisplayMesh::DisplayMesh(const Cloud& cloud, int threads) : cloud_(cloud), threads_(threads) {
  if (cloud.empty()) throw std::invalid_argument("DisplayMesh: the cloud is empty");
  bricks_.resize(cubeBricks(cloud).prod());
  std::vector<int> all(bricks_.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  make(all);
}

void DisplayMesh::make(const std::vector<int>& numbers) {
  const Eigen::Vector3i cubes = cubeBricks(cloud_);
  parallelFor(numbers.size(), threads_, [&](std::size_t i, int) {
    const Eigen::Vector3i place = gridCell(numbers[i], cubes);
    bricks_[numbers[i]] = uniform(cloud_, place) ? nullptr : BrickMesher(cloud_, place).run();
  });
}

std::vector<int> DisplayMesh::renew(const Cloud& after) {
  if (after.empty() || after.bricks() != cloud_.bricks() ||
      after.voxelSize() != cloud_.voxelSize() || after.materials() != cloud_.materials())
    throw std::invalid_argument(
        "DisplayMesh::renew: the cloud has another grid or other materials; build a new mesh");
  std::vector<int> numbers = touched(cloud_, after);
  cloud_ = after;
  make(numbers);
  return numbers;
}

Mesh DisplayMesh::mesh(std::vector<std::uint8_t>* materials) const {
  Mesh mesh;
  if (materials) materials->clear();
  for (const auto& brick : bricks_) {
    if (!brick) continue;
    const int first = static_cast<int>(mesh.vertices.size());
    for (const Eigen::Vector3f& v : brick->vertices)
      mesh.vertices.push_back(cloud_.origin() + cloud_.voxelSize() * v.cast<double>());
    for (const Eigen::Vector3i& t : brick->triangles)
      mesh.triangles.push_back(t + Eigen::Vector3i::Constant(first));
    if (materials)
      materials->insert(materials->end(), brick->materials.begin(), brick->materials.end());
  }
  return mesh;
}

}  // namespace cloudcontact
