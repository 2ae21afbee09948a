// Repairs the direction of triangles: see mesh_orientation.h.
#include "mesh/mesh_orientation.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>

#include "mesh/mesh_topology.h"
#include "mesh/winding.h"

namespace cloudcontact {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// A triangle's vertices in ascending order, and whether sorting reversed its direction.
struct Corners {
  std::array<int, 3> sorted;
  bool turned;
  int triangle;
};

Corners cornersOf(const Mesh& mesh, int triangle) {
  const Vector3i& t = mesh.triangles[triangle];
  int k = 0;
  if (t[1] < t[k]) k = 1;
  if (t[2] < t[k]) k = 2;
  const int b = t[(k + 1) % 3], c = t[(k + 2) % 3];
  return {{t[k], std::min(b, c), std::max(b, c)}, b > c, triangle};
}

// Union-find that also stores whether a triangle opposes its root. Sets are joined by size, so
// paths are no longer than the logarithm of the number of triangles.
class Orientation {
 public:
  explicit Orientation(std::size_t triangles)
      : parent_(triangles), size_(triangles, 1), against_(triangles, 0) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  // The root of `t`, and in `against` whether t opposes it.
  int root(int t, bool& against) const {
    for (against = false; parent_[t] != t; t = parent_[t]) against ^= against_[t] != 0;
    return t;
  }
  // Joins a and b, which agree or oppose each other. Contradictions (a Moebius strip) are ignored.
  void join(int a, int b, bool opposed) {
    bool againstA = false, againstB = false;
    int keep = root(a, againstA), give = root(b, againstB);
    if (keep == give) return;
    if (size_[keep] < size_[give]) std::swap(keep, give);
    parent_[give] = keep;
    size_[keep] += size_[give];
    against_[give] = againstA ^ againstB ^ opposed;
  }

 private:
  std::vector<int> parent_, size_;
  std::vector<char> against_;
};

// Six times the signed volume of each component.
std::vector<double> componentVolumes(const Mesh& mesh, const std::vector<int>& of, int count) {
  std::vector<double> volume(count, 0);
  const Vector3d middle = middleOf(mesh);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vector3i& v = mesh.triangles[t];
    const Vector3d a = mesh.vertices[v[0]] - middle, b = mesh.vertices[v[1]] - middle,
                   c = mesh.vertices[v[2]] - middle;
    volume[of[t]] += a.dot(b.cross(c));
  }
  return volume;
}

// Whether each component has no boundary.
std::vector<char> closedComponents(const Mesh& mesh, const std::vector<int>& of, int count) {
  std::vector<char> closed(count, 1);
  forEachEdge(sortedEdgeSides(mesh), [&](const EdgeSide* first, const EdgeSide* last) {
    for (const EdgeSide* s = first; s != last && last - first != 2; ++s)
      closed[of[s->triangle]] = 0;
  });
  return closed;
}

// The winding number of the other components at a point of component `part`.
double windingAround(const Mesh& mesh, const std::vector<int>& of, int part) {
  const auto first = static_cast<std::size_t>(std::find(of.begin(), of.end(), part) - of.begin());
  const auto corner = [&](std::size_t t, int k) { return mesh.vertices[mesh.triangles[t][k]]; };
  const Vector3d probe = (corner(first, 0) + corner(first, 1) + corner(first, 2)) / 3;
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (of[t] != part) sum += windingOf(corner(t, 0), corner(t, 1), corner(t, 2), probe);
  return sum;
}

}  // namespace

void flip(Vector3i& triangle) {
  std::swap(triangle[1], triangle[2]);
}

void dropDoubles(Mesh& mesh) {
  std::vector<Corners> all;
  all.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    all.push_back(cornersOf(mesh, static_cast<int>(t)));
  std::sort(all.begin(), all.end(), [](const Corners& a, const Corners& b) {
    return std::tie(a.sorted, a.triangle) < std::tie(b.sorted, b.triangle);
  });
  std::vector<char> keep(all.size(), 1), second(all.size(), 0);
  bool allTwoSided = !all.empty();
  for (std::size_t i = 0; i < all.size();) {
    std::array<int, 2> first{-1, -1};
    std::size_t j = i;
    for (; j < all.size() && all[j].sorted == all[i].sorted; ++j) {
      int& mine = first[all[j].turned];
      if (mine >= 0)
        keep[all[j].triangle] = 0;
      else
        mine = all[j].triangle;
    }
    if (first[0] < 0 || first[1] < 0)
      allTwoSided = false;
    else
      second[std::max(first[0], first[1])] = 1;
    i = j;
  }
  std::size_t out = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (keep[t] && !(allTwoSided && second[t])) mesh.triangles[out++] = mesh.triangles[t];
  mesh.triangles.resize(out);
}

void agreeInDirection(Mesh& mesh) {
  Orientation orientation(mesh.triangles.size());
  forEachEdge(sortedEdgeSides(mesh), [&](const EdgeSide* first, const EdgeSide* last) {
    if (last - first == 2)
      orientation.join(first[0].triangle, first[1].triangle, first[0].forward == first[1].forward);
  });
  std::vector<double> vote(mesh.triangles.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    bool against = false;
    const int root = orientation.root(static_cast<int>(t), against);
    vote[root] += against ? -triangleArea(mesh, t) : triangleArea(mesh, t);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    bool against = false;
    const int root = orientation.root(static_cast<int>(t), against);
    if (against != (vote[root] < 0)) flip(mesh.triangles[t]);
  }
}

void turnStrayComponents(Mesh& mesh) {
  int count = 0;
  const std::vector<int> of = components(mesh, count);
  if (count < 2) return;
  const std::vector<double> volume = componentVolumes(mesh, of, count);
  const std::vector<char> closed = closedComponents(mesh, of, count);
  std::vector<char> turn(volume.size(), 0);
  for (std::size_t p = 0; p < volume.size(); ++p)
    turn[p] = volume[p] < 0 && closed[p] && windingAround(mesh, of, static_cast<int>(p)) < 0.25;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (turn[of[t]]) flip(mesh.triangles[t]);
}

}  // namespace cloudcontact
