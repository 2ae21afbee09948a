// Topology of meshes: see mesh_topology.h.
#include "mesh/mesh_topology.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>

namespace cloudcontact {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Equal for vertices that compare equal: -0 counts as 0.
std::uint64_t hashOf(const Vector3d& v) {
  std::uint64_t hash = 0;
  for (int k = 0; k < 3; ++k) {
    hash = (hash ^ std::bit_cast<std::uint64_t>(v[k] + 0.0)) * 0x9E3779B97F4A7C15ull;
    hash ^= hash >> 32;
  }
  return hash;
}

// For each vertex the lowest index of a vertex with equal coordinates, by an open hash table that
// is at most half full: ten times as fast as sorting.
std::vector<int> equalVertices(const std::vector<Vector3d>& v) {
  const std::size_t mask = std::bit_ceil(2 * v.size() + 1) - 1;
  std::vector<int> table(mask + 1, -1), same(v.size());
  for (std::size_t i = 0; i < v.size(); ++i) {
    std::size_t place = hashOf(v[i]) & mask;
    while (table[place] >= 0 && v[table[place]] != v[i]) place = (place + 1) & mask;
    if (table[place] < 0) table[place] = static_cast<int>(i);
    same[i] = table[place];
  }
  return same;
}

// For each vertex the first vertex within the tolerance, found in a hash grid of cells of that
// size.
std::vector<int> nearVertices(const std::vector<Vector3d>& v, double tolerance) {
  using Key = Eigen::Matrix<std::int64_t, 3, 1>;
  const auto hash = [](const Key& k) {
    const std::uint64_t h = static_cast<std::uint64_t>(k[0]) * 0x9E3779B97F4A7C15ull ^
                            static_cast<std::uint64_t>(k[1]) * 0xC2B2AE3D27D4EB4Full ^
                            static_cast<std::uint64_t>(k[2]) * 0x165667B19E3779F9ull;
    return static_cast<std::size_t>(h ^ (h >> 29));
  };
  std::unordered_multimap<Key, int, decltype(hash)> cells(v.size(), hash);
  const auto keyOf = [&](const Vector3d& p) {
    return Key((p / tolerance).array().floor().max(-9e17).min(9e17).cast<std::int64_t>());
  };
  std::vector<int> same(v.size());
  for (std::size_t i = 0; i < v.size(); ++i) {
    const Key key = keyOf(v[i]);
    int best = static_cast<int>(i);
    for (int n = 0; n < 27; ++n) {
      const Key near = key + Key(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      const auto [first, last] = cells.equal_range(near);
      for (auto it = first; it != last; ++it)
        if ((v[it->second] - v[i]).norm() <= tolerance) best = std::min(best, it->second);
    }
    same[i] = best;
    if (best == static_cast<int>(i)) cells.emplace(key, best);
  }
  return same;
}

int rootOf(std::vector<int>& parent, int i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

// A directed edge that a cap must have.
struct FillEdge {
  int from, to;
  bool used = false;
};

// The edges that caps must have to cancel the boundary, sorted by their start.
std::vector<FillEdge> fillEdges(const Mesh& mesh) {
  std::vector<FillEdge> edges;
  forEachEdge(sortedEdgeSides(mesh), [&](const EdgeSide* first, const EdgeSide* last) {
    int excess = 0;
    for (const EdgeSide* s = first; s != last; ++s) excess += s->forward ? 1 : -1;
    for (; excess > 0; --excess) edges.push_back({first->high, first->low});
    for (; excess < 0; ++excess) edges.push_back({first->low, first->high});
  });
  std::stable_sort(edges.begin(), edges.end(),
                   [](const FillEdge& a, const FillEdge& b) { return a.from < b.from; });
  return edges;
}

// The unused edge out of `at` that turns back most sharply from `incoming`: a crack whose two sides
// share their ends then becomes a loop of its own.
FillEdge* sharpestTurn(std::vector<FillEdge>& edges, const Mesh& mesh, int at,
                       const Vector3d& incoming) {
  auto it = std::lower_bound(edges.begin(), edges.end(), at,
                             [](const FillEdge& e, int v) { return e.from < v; });
  FillEdge* best = nullptr;
  double bestCosine = 2;
  for (; it != edges.end() && it->from == at; ++it) {
    if (it->used) continue;
    const Vector3d out = (mesh.vertices[it->to] - mesh.vertices[at]).normalized();
    const double cosine = out.dot(incoming);
    if (cosine < bestCosine) bestCosine = cosine, best = &*it;
  }
  return best;
}

}  // namespace

Mesh welded(const Mesh& mesh, double tolerance) {
  const std::vector<int> same =
      tolerance > 0 ? nearVertices(mesh.vertices, tolerance) : equalVertices(mesh.vertices);
  Mesh result;
  result.triangles.reserve(mesh.triangles.size());
  std::vector<int> renamed(mesh.vertices.size(), -1);
  for (const Vector3i& t : mesh.triangles) {
    Vector3i w(same[t[0]], same[t[1]], same[t[2]]);
    if (w[0] == w[1] || w[1] == w[2] || w[2] == w[0]) continue;
    for (int k = 0; k < 3; ++k) {
      int& name = renamed[w[k]];
      if (name < 0) {
        name = static_cast<int>(result.vertices.size());
        result.vertices.push_back(mesh.vertices[w[k]]);
      }
      w[k] = name;
    }
    result.triangles.push_back(w);
  }
  return result;
}

// A counting sort by the lower vertex, then small sorts of the about three sides of each.
std::vector<EdgeSide> sortedEdgeSides(const Mesh& mesh) {
  std::vector<std::size_t> first(mesh.vertices.size() + 1, 0);
  const auto forEachSide = [&](auto&& visit) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        const int a = mesh.triangles[t][k], b = mesh.triangles[t][k < 2 ? k + 1 : 0];
        visit(EdgeSide{std::min(a, b), std::max(a, b), static_cast<int>(t), a < b});
      }
  };
  forEachSide([&](const EdgeSide& s) { ++first[static_cast<std::size_t>(s.low) + 1]; });
  for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
  std::vector<EdgeSide> sides(first.back());
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  forEachSide([&](const EdgeSide& s) { sides[next[s.low]++] = s; });
  for (std::size_t v = 0; v + 1 < first.size(); ++v)
    std::sort(sides.data() + first[v], sides.data() + first[v + 1],
              [](const EdgeSide& a, const EdgeSide& b) {
                return std::tie(a.high, a.triangle, a.forward) <
                       std::tie(b.high, b.triangle, b.forward);
              });
  return sides;
}

std::vector<int> components(const Mesh& mesh, int& count) {
  std::vector<int> parent(mesh.triangles.size());
  std::iota(parent.begin(), parent.end(), 0);
  forEachEdge(sortedEdgeSides(mesh), [&](const EdgeSide* first, const EdgeSide* last) {
    if (last - first != 2) return;
    const int a = rootOf(parent, first[0].triangle), b = rootOf(parent, first[1].triangle);
    parent[std::max(a, b)] = std::min(a, b);
  });
  count = 0;
  std::vector<int> number(parent.size());
  for (std::size_t t = 0; t < parent.size(); ++t) {
    const int root = rootOf(parent, static_cast<int>(t));
    number[t] = root == static_cast<int>(t) ? count++ : number[root];
  }
  return number;
}

// A counting sort of the sides by their lower vertex. Each side then finds its partner among the
// few of that vertex.
bool isOneClosedSurface(const Mesh& mesh) {
  constexpr std::uint64_t kMost = 100;          // comparisons per side, in the mean
  if (mesh.triangles.size() < 4) return false;  // two triangles back to back bound nothing
  struct Side {
    int high, triangle;
    bool forward;
  };
  std::vector<std::uint32_t> first(mesh.vertices.size() + 1, 0);
  for (const Vector3i& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) ++first[std::min(t[k], t[(k + 1) % 3])];
  std::uint32_t all = 0;
  std::uint64_t looks = 0;
  for (std::uint32_t& f : first) {
    looks += std::uint64_t{f} * f;
    f = std::exchange(all, all + f);
  }
  if (looks > kMost * all) return false;
  std::vector<Side> sides(all);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.triangles[t][k], b = mesh.triangles[t][k < 2 ? k + 1 : 0];
      sides[first[std::min(a, b)]++] = {std::max(a, b), static_cast<int>(t), a < b};
    }
  std::vector<int> parent(mesh.triangles.size());
  std::iota(parent.begin(), parent.end(), 0);
  std::size_t parts = parent.size();
  for (std::size_t v = 0, begin = 0; v < mesh.vertices.size(); begin = first[v++])
    for (std::size_t i = begin; i < first[v]; ++i) {
      int others = 0;
      for (std::size_t j = begin; j < first[v]; ++j) {
        if (j == i || sides[j].high != sides[i].high) continue;
        if (++others > 1 || sides[j].forward == sides[i].forward) return false;
        const int a = rootOf(parent, sides[i].triangle), b = rootOf(parent, sides[j].triangle);
        parts -= a != b;
        parent[std::max(a, b)] = std::min(a, b);
      }
      if (others == 0) return false;
    }
  return parts == 1;
}

std::vector<std::vector<int>> boundaryLoops(const Mesh& mesh) {
  std::vector<FillEdge> edges = fillEdges(mesh);
  std::vector<std::vector<int>> loops;
  std::unordered_map<int, std::size_t> placeInPath;
  for (FillEdge& start : edges) {
    if (start.used) continue;
    std::vector<int> path;
    placeInPath.clear();
    // Every vertex has as many fill edges in as out, so a walk can end only where it began.
    for (FillEdge* edge = &start; edge;) {
      edge->used = true;
      placeInPath[edge->from] = path.size();
      path.push_back(edge->from);
      if (const auto met = placeInPath.find(edge->to); met != placeInPath.end()) {
        const std::size_t cut = met->second;
        loops.emplace_back(path.begin() + static_cast<std::ptrdiff_t>(cut), path.end());
        for (std::size_t i = cut; i < path.size(); ++i) placeInPath.erase(path[i]);
        path.resize(cut);
      }
      const Vector3d in = (mesh.vertices[edge->to] - mesh.vertices[edge->from]).normalized();
      edge = sharpestTurn(edges, mesh, edge->to, in);
    }
  }
  return loops;
}

double sixVolumes(const Mesh& mesh, const Vector3d& apex) {
  double sum = 0;
  for (const Vector3i& t : mesh.triangles) {
    const Vector3d a = mesh.vertices[t[0]] - apex, b = mesh.vertices[t[1]] - apex,
                   c = mesh.vertices[t[2]] - apex;
    sum += a.dot(b.cross(c));
  }
  return sum;
}

double triangleArea(const Mesh& mesh, std::size_t triangle) {
  const Vector3i& t = mesh.triangles[triangle];
  const Vector3d& a = mesh.vertices[t[0]];
  return 0.5 * (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm();
}

double totalArea(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) sum += triangleArea(mesh, t);
  return sum;
}

Vector3d middleOf(const Mesh& mesh) {
  if (mesh.vertices.empty()) return Vector3d::Zero();
  Vector3d low = mesh.vertices.front(), high = low;
  for (const Vector3d& v : mesh.vertices) low = low.cwiseMin(v), high = high.cwiseMax(v);
  return low + 0.5 * (high - low);
}

}  // namespace cloudcontact
