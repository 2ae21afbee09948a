// Looking at meshes and mending them: see mesh.h.
#include <cloudcontact/mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "geometry/mesh_topology.h"
#include "geometry/winding.h"

namespace cloudcontact {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

void flip(Vector3i& triangle) {
  std::swap(triangle[1], triangle[2]);
}

// A triangle's vertices from its lowest on, and whether sorting them would turn it over.
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

// Drops triangles that stand twice in the same direction (their volume would count twice). Where
// every triangle has a twin in the other direction, a mesh made two-sided for display, one of the
// two goes; elsewhere such pairs are two bodies that touch, and stay.
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

// Union-find that also knows whether a triangle stands against its root. Joined by size, so no
// path is longer than the logarithm of the number of triangles.
class Orientation {
 public:
  explicit Orientation(std::size_t triangles)
      : parent_(triangles), size_(triangles, 1), against_(triangles, 0) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  // The root of `t`, and in `against` whether t runs against it.
  int root(int t, bool& against) const {
    for (against = false; parent_[t] != t; t = parent_[t]) against ^= against_[t] != 0;
    return t;
  }
  // Says that a and b agree, or oppose each other; a later contradiction (a Moebius strip) is let
  // be.
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

// Neighbours agree, each component as the greater part of its area stood.
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

// A component turned inside out that lies inside no other is no cavity, but a body turned wrongly.
void turnStrayComponents(Mesh& mesh) {
  int count = 0;
  const std::vector<int> of = components(mesh, count);
  if (count < 2) return;
  std::vector<Mesh> parts(static_cast<std::size_t>(count));
  for (Mesh& part : parts) part.vertices = {};
  std::vector<double> volume(parts.size(), 0);
  const Vector3d middle = middleOf(mesh);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vector3i& v = mesh.triangles[t];
    const Vector3d a = mesh.vertices[v[0]] - middle, b = mesh.vertices[v[1]] - middle,
                   c = mesh.vertices[v[2]] - middle;
    volume[of[t]] += a.dot(b.cross(c));
    parts[of[t]].triangles.push_back(v);
  }
  std::vector<char> turn(parts.size(), 0);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (volume[p] >= 0) continue;
    if (!boundaryLoops({mesh.vertices, parts[p].triangles}).empty()) continue;
    const Vector3i& v = parts[p].triangles.front();
    const Vector3d probe = (mesh.vertices[v[0]] + mesh.vertices[v[1]] + mesh.vertices[v[2]]) / 3;
    double around = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      if (of[t] != static_cast<int>(p)) {
        const Vector3i& w = mesh.triangles[t];
        around += windingOf(mesh.vertices[w[0]], mesh.vertices[w[1]], mesh.vertices[w[2]], probe);
      }
    turn[p] = around < 0.25;
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (turn[of[t]]) flip(mesh.triangles[t]);
}

}  // namespace

Mesh Mesh::scaled(const Eigen::Vector3d& factor) const {
  Mesh result = *this;
  for (Vector3d& v : result.vertices) v = v.cwiseProduct(factor);
  // A mirrored mesh is turned inside out; turned triangles put that right.
  if (factor.prod() < 0)
    for (Vector3i& t : result.triangles) flip(t);
  return result;
}

MeshReport inspect(const Mesh& mesh) {
  checkMesh(mesh);
  const Mesh clean = welded(mesh, 0);
  MeshReport report;
  report.degenerateTriangles = mesh.triangles.size() - clean.triangles.size();
  forEachEdge(sortedEdgeSides(clean), [&](const EdgeSide* first, const EdgeSide* last) {
    if (last - first == 1) ++report.openEdges;
    if (last - first > 2) ++report.overusedEdges;
  });
  report.volume = sixVolumes(clean, middleOf(clean)) / 6;
  report.area = totalArea(clean);
  return report;
}

Mesh mended(const Mesh& mesh, double tolerance) {
  checkMesh(mesh);
  Mesh result = welded(mesh, tolerance);
  dropDoubles(result);
  agreeInDirection(result);
  if (sixVolumes(result, middleOf(result)) < 0)
    for (Vector3i& t : result.triangles) flip(t);
  turnStrayComponents(result);
  return result;
}

}  // namespace cloudcontact
