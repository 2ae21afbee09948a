// The generalized winding number: see winding.h.
#include "mesh/winding.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cloudcontact {

using Eigen::Vector3d;

double windingOf(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& point) {
  const Vector3d u = a - point, v = b - point, w = c - point;
  const double lu = u.norm(), lv = v.norm(), lw = w.norm();
  const double numerator = u.dot(v.cross(w));
  const double denominator = lu * lv * lw + u.dot(v) * lw + v.dot(w) * lu + w.dot(u) * lv;
  return std::atan2(numerator, denominator) / (2 * std::numbers::pi);
}

double windingNumber(const Mesh& mesh, const Vector3d& point) {
  double sum = 0;
  for (const Eigen::Vector3i& t : mesh.triangles)
    sum += windingOf(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]], point);
  return sum;
}

namespace {
constexpr std::size_t kLeafTriangles = 8;
// A group is far where its distance is this many times its radius.
constexpr double kFar = 2.5;
}  // namespace

WindingTree::WindingTree(const std::vector<Vector3d>& vertices,
                         const std::vector<Eigen::Vector3i>& triangles) {
  triangles_.reserve(triangles.size());
  for (const Eigen::Vector3i& t : triangles)
    triangles_.push_back({vertices[t[0]], vertices[t[1]], vertices[t[2]]});
  if (!triangles_.empty()) build(0, triangles_.size());
}

void WindingTree::build(std::size_t first, std::size_t last) {
  const std::size_t index = nodes_.size();
  nodes_.emplace_back();
  Node node;
  node.first = first, node.last = last;
  Vector3d low = triangles_[first].centroid(), high = low;
  double area = 0;
  for (std::size_t t = first; t < last; ++t) {
    const Vector3d centroid = triangles_[t].centroid(), vector = triangles_[t].areaVector();
    low = low.cwiseMin(centroid), high = high.cwiseMax(centroid);
    node.areaVector += vector;
    node.center += vector.norm() * centroid;
    area += vector.norm();
  }
  node.center = area > 0 ? Vector3d(node.center / area) : Vector3d(0.5 * (low + high));
  for (std::size_t t = first; t < last; ++t)
    for (const Vector3d& corner : {triangles_[t].a, triangles_[t].b, triangles_[t].c})
      node.radius = std::max(node.radius, (corner - node.center).norm());
  if (last - first > kLeafTriangles) {
    Eigen::Index axis = 0;
    (high - low).maxCoeff(&axis);
    const std::size_t middle = first + (last - first) / 2;
    const auto at = [&](std::size_t t) {
      return triangles_.begin() + static_cast<std::ptrdiff_t>(t);
    };
    std::nth_element(at(first), at(middle), at(last), [&](const Triangle& a, const Triangle& b) {
      return a.centroid()[axis] < b.centroid()[axis];
    });
    build(first, middle);
    node.second = nodes_.size();
    build(middle, last);
  }
  nodes_[index] = node;
}

double WindingTree::sum(std::size_t index, const Vector3d& point) const {
  const Node& node = nodes_[index];
  const Vector3d to = node.center - point;
  const double distance = to.norm();
  if (distance > kFar * node.radius)
    return to.dot(node.areaVector) / (4 * std::numbers::pi * distance * distance * distance);
  if (node.second != 0) return sum(index + 1, point) + sum(node.second, point);
  double leaf = 0;
  for (std::size_t t = node.first; t < node.last; ++t)
    leaf += windingOf(triangles_[t].a, triangles_[t].b, triangles_[t].c, point);
  return leaf;
}

double WindingTree::at(const Vector3d& point) const {
  return nodes_.empty() ? 0 : sum(0, point);
}

}  // namespace cloudcontact
