// Finds closest points in a tree of boxes and signs by pseudo-normals or winding numbers.
#include "scene/mesh_distance.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <stdexcept>

namespace cloudcontact::program {
namespace {

constexpr int kLeafTriangles = 4;

struct LessVec3 {
  bool operator()(const Vec3& a, const Vec3& b) const {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  }
};

// Angle at `corner` between the directions to `a` and `b`.
double angleAt(const Vec3& corner, const Vec3& a, const Vec3& b) {
  const Vec3 u = a - corner, v = b - corner;
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

// Solid angle of a triangle seen from the origin, over 4 pi (van Oosterom and Strackee 1983).
double solidAngle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double over = a.dot(b.cross(c));
  const double under = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return std::atan2(over, under) / (2 * std::numbers::pi);
}

double squaredDistance(const Eigen::AlignedBox3d& box, const Vec3& p) {
  return (box.min() - p).cwiseMax(p - box.max()).cwiseMax(0).squaredNorm();
}

}  // namespace

MeshDistance::MeshDistance(const Mesh& mesh) {
  weld(mesh);
  if (triangles_.empty()) throw std::invalid_argument("mesh: has no triangle with an area");
  std::vector<Vec3> centers;
  for (const auto& t : triangles_)
    centers.push_back((vertices_[t[0]] + vertices_[t[1]] + vertices_[t[2]]) / 3);
  nodes_.reserve(2 * triangles_.size());
  nodes_.emplace_back();
  build(0, 0, static_cast<int>(triangles_.size()), centers);
  pseudoNormals();
}

// Merges equal positions: files often give each face its own vertices.
void MeshDistance::weld(const Mesh& mesh) {
  std::map<Vec3, int, LessVec3> known;
  std::vector<int> index;
  for (const Vec3& v : mesh.vertices) {
    const auto [found, fresh] = known.emplace(v, static_cast<int>(vertices_.size()));
    if (fresh) vertices_.push_back(v);
    index.push_back(found->second);
  }
  for (const auto& t : mesh.triangles) {
    const std::array<int, 3> w{index[t[0]], index[t[1]], index[t[2]]};
    const Vec3 cross = (vertices_[w[1]] - vertices_[w[0]]).cross(vertices_[w[2]] - vertices_[w[0]]);
    if (cross.norm() > 0) triangles_.push_back(w);
  }
}

// Splits triangles [first, first + count) at the middle of the longest axis of their centers.
void MeshDistance::build(int node, int first, int count, std::vector<Vec3>& centers) {
  Eigen::AlignedBox3d box, middle;
  for (int i = first; i < first + count; ++i) {
    for (int v : triangles_[i]) box.extend(vertices_[v]);
    middle.extend(centers[i]);
  }
  nodes_[node].box = box;
  nodes_[node].first = first;
  nodes_[node].count = count;
  if (count <= kLeafTriangles) return;
  int axis = 0;
  middle.sizes().maxCoeff(&axis);
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), first);
  std::nth_element(order.begin(), order.begin() + count / 2, order.end(), [&](int a, int b) {
    return std::pair(centers[a][axis], a) < std::pair(centers[b][axis], b);
  });
  std::vector<std::array<int, 3>> triangles(count);
  std::vector<Vec3> moved(count);
  for (int i = 0; i < count; ++i) {
    triangles[i] = triangles_[order[i]];
    moved[i] = centers[order[i]];
  }
  std::copy(triangles.begin(), triangles.end(), triangles_.begin() + first);
  std::copy(moved.begin(), moved.end(), centers.begin() + first);
  const int children = static_cast<int>(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  nodes_[node].first = children;
  nodes_[node].count = 0;
  build(children, first, count / 2, centers);
  build(children + 1, first + count / 2, count - count / 2, centers);
}

void MeshDistance::pseudoNormals() {
  const std::size_t n = triangles_.size();
  faceNormal_.resize(n);
  edgeNormal_.resize(n);
  edgeBad_.resize(n);
  vertexNormal_.assign(vertices_.size(), Vec3::Zero());
  vertexBad_.assign(vertices_.size(), 0);
  std::map<std::pair<int, int>, std::pair<Vec3, int>> edges;  // sum of normals, faces
  const auto edge = [&](std::size_t t, int k) {
    return std::minmax(triangles_[t][k], triangles_[t][(k + 1) % 3]);
  };
  for (std::size_t t = 0; t < n; ++t) {
    const auto& v = triangles_[t];
    const Vec3 &a = vertices_[v[0]], &b = vertices_[v[1]], &c = vertices_[v[2]];
    faceNormal_[t] = (b - a).cross(c - a).normalized();
    vertexNormal_[v[0]] += angleAt(a, b, c) * faceNormal_[t];
    vertexNormal_[v[1]] += angleAt(b, c, a) * faceNormal_[t];
    vertexNormal_[v[2]] += angleAt(c, a, b) * faceNormal_[t];
    for (int k = 0; k < 3; ++k) {
      auto& sum = edges.try_emplace(edge(t, k), Vec3::Zero(), 0).first->second;
      sum.first += faceNormal_[t];
      ++sum.second;
    }
  }
  for (std::size_t t = 0; t < n; ++t)
    for (int k = 0; k < 3; ++k) {
      const auto& sum = edges.at(edge(t, k));
      edgeNormal_[t][k] = sum.first;
      edgeBad_[t][k] = sum.second != 2;
      if (edgeBad_[t][k]) vertexBad_[triangles_[t][k]] = vertexBad_[triangles_[t][(k + 1) % 3]] = 1;
    }
}

// The closest point lies inside the face or on the nearest of its three edges.
void MeshDistance::closestInTriangle(int triangle, const Vec3& point, Closest& best) const {
  const auto& v = triangles_[triangle];
  const Vec3& normal = faceNormal_[triangle];
  const double height = normal.dot(point - vertices_[v[0]]);
  if (height * height >= best.squared) return;
  bool inside = true;
  for (int k = 0; k < 3; ++k) {
    const Vec3 &a = vertices_[v[k]], &b = vertices_[v[(k + 1) % 3]];
    const Vec3 along = b - a, offset = point - a;
    if (along.cross(offset).dot(normal) >= 0) continue;
    inside = false;
    const double t = std::clamp(offset.dot(along) / along.squaredNorm(), 0.0, 1.0);
    const Vec3 foot = a + t * along;
    const double squared = (point - foot).squaredNorm();
    if (squared >= best.squared) continue;
    const int feature = t <= 0 ? 4 + k : t >= 1 ? 4 + (k + 1) % 3 : 1 + k;
    best = {squared, triangle, feature, foot};
  }
  if (inside) best = {height * height, triangle, 0, point - height * normal};
}

MeshDistance::Closest MeshDistance::closest(const Vec3& point, int hint) const {
  Closest best{std::numeric_limits<double>::infinity(), hint, 0, Vec3::Zero()};
  closestInTriangle(hint, point, best);
  std::array<std::pair<int, double>, 128> stack;  // nodes split in half, so the depth is below 64
  int size = 0;
  stack[size++] = {0, squaredDistance(nodes_[0].box, point)};
  while (size > 0) {
    const auto [index, distance] = stack[--size];
    if (distance >= best.squared) continue;
    const Node& node = nodes_[index];
    if (node.count > 0) {
      for (int i = 0; i < node.count; ++i) closestInTriangle(node.first + i, point, best);
      continue;
    }
    const double left = squaredDistance(nodes_[node.first].box, point);
    const double right = squaredDistance(nodes_[node.first + 1].box, point);
    const std::pair<int, double> a{node.first, left}, b{node.first + 1, right};
    stack[size++] = left < right ? b : a;
    stack[size++] = left < right ? a : b;
  }
  return best;
}

double MeshDistance::depth(const Vec3& point, double reach, int* hint) const {
  // Beyond the reach from the box the answer is known.
  const double toBox = squaredDistance(bounds(), point);
  if (toBox > reach * reach) return -std::numeric_limits<double>::infinity();
  const Closest best = closest(point, hint ? *hint : 0);
  if (hint) *hint = best.triangle;
  const auto& t = triangles_[best.triangle];
  const int k = best.feature;
  const bool bad = k == 0 ? false : k < 4 ? edgeBad_[best.triangle][k - 1] : vertexBad_[t[k - 4]];
  bool inside;
  if (bad) {
    inside = winding(point) > 0.5;
  } else {
    const Vec3& normal = k == 0  ? faceNormal_[best.triangle]
                         : k < 4 ? edgeNormal_[best.triangle][k - 1]
                                 : vertexNormal_[t[k - 4]];
    inside = normal.dot(point - best.point) < 0;
  }
  const double distance = std::sqrt(best.squared);
  return inside ? distance : -distance;
}

double MeshDistance::winding(const Vec3& point) const {
  double sum = 0;
  for (const auto& t : triangles_)
    sum += solidAngle(vertices_[t[0]] - point, vertices_[t[1]] - point, vertices_[t[2]] - point);
  return sum;
}

std::vector<Vec3> surfacePoints(const Mesh& mesh, int wanted) {
  std::vector<Vec3> points = mesh.vertices;
  double area = 0;
  const auto corners = [&](const Eigen::Vector3i& t) {
    // Starts at the corner opposite the longest side, so that a sliver gets a thin grid.
    std::array<Vec3, 3> c{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
    int longest = 0;
    double length = 0;
    for (int k = 0; k < 3; ++k)
      if (const double l = (c[(k + 1) % 3] - c[(k + 2) % 3]).norm(); l > length)
        length = l, longest = k;
    std::rotate(c.begin(), c.begin() + longest, c.end());
    return c;
  };
  for (const auto& t : mesh.triangles) {
    const auto c = corners(t);
    area += (c[1] - c[0]).cross(c[2] - c[0]).norm() / 2;
  }
  const double spacing = std::sqrt(area / std::max(1, wanted));
  for (const auto& t : mesh.triangles) {
    const auto c = corners(t);
    const Vec3 u = c[1] - c[0], v = c[2] - c[0];
    const int nu = static_cast<int>(std::ceil(u.norm() / spacing));
    const int nv = static_cast<int>(std::ceil(v.norm() / spacing));
    if (nu == 1 && nv == 1) continue;  // its vertices are close enough
    for (int i = 0; i < nu; ++i)
      for (int j = 0; j < nv; ++j) {
        const double a = (i + 0.5) / nu, b = (j + 0.5) / nv;
        if (a + b <= 1) points.push_back(c[0] + a * u + b * v);
      }
  }
  return points;
}

}  // namespace cloudcontact::program
