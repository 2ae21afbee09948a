// A k-d tree without pointers: the middle entry of a range splits it. See point_tree.h.
#include "objects/point_tree.h"

#include <algorithm>
#include <limits>

namespace cloudcontact {

PointTree::PointTree(const std::vector<Vec3>& points) {
  points_.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    points_.push_back({points[i], static_cast<std::uint32_t>(i), 0});
  build(0, points_.size());
}

void PointTree::build(std::size_t first, std::size_t last) {
  if (last - first <= kLeaf) return;
  Eigen::AlignedBox3d box;
  for (std::size_t i = first; i < last; ++i) box.extend(points_[i].position);
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const std::size_t middle = first + (last - first) / 2;
  const auto at = [&](std::size_t i) { return points_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(first), at(middle), at(last), [axis](const Entry& a, const Entry& b) {
    return a.position[axis] != b.position[axis] ? a.position[axis] < b.position[axis]
                                                : a.index < b.index;
  });
  points_[middle].axis = static_cast<std::uint32_t>(axis);
  build(first, middle);
  build(middle + 1, last);
}

// The nearest points so far, in a heap with the farthest on top.
struct PointTree::Best {
  std::size_t count;
  std::vector<std::pair<double, std::size_t>> heap;
  double reach() const {
    return heap.size() < count ? std::numeric_limits<double>::infinity() : heap.front().first;
  }
  void offer(double square, std::size_t index) {
    if (square >= reach()) return;
    if (heap.size() == count) {
      std::pop_heap(heap.begin(), heap.end());
      heap.pop_back();
    }
    heap.emplace_back(square, index);
    std::push_heap(heap.begin(), heap.end());
  }
};

// Tests the points of a range, the nearer half first. The other half is searched only where
// `reach`, the square of the current search radius, exceeds the distance to the plane between them.
template <typename Test, typename Reach>
void PointTree::search(std::size_t first, std::size_t last, const Vec3& to, Test&& test,
                       Reach&& reach) const {
  if (last - first <= kLeaf) {
    for (std::size_t i = first; i < last; ++i) test(points_[i]);
    return;
  }
  const std::size_t middle = first + (last - first) / 2;
  const Entry& e = points_[middle];
  const double side = to[e.axis] - e.position[e.axis];
  const bool below = side <= 0;
  below ? search(first, middle, to, test, reach) : search(middle + 1, last, to, test, reach);
  test(e);
  if (side * side < reach())
    below ? search(middle + 1, last, to, test, reach) : search(first, middle, to, test, reach);
}

std::size_t PointTree::nearest(const Vec3& to) const {
  double square = std::numeric_limits<double>::infinity();
  const Entry* best = &points_.front();
  search(
      0, points_.size(), to,
      [&](const Entry& e) {
        if (const double d = (e.position - to).squaredNorm(); d < square) square = d, best = &e;
      },
      [&] { return square; });
  return best->index;
}

void PointTree::nearest(const Vec3& to, std::size_t count, std::vector<std::size_t>& found) const {
  Best best{count, {}};
  best.heap.reserve(count + 1);
  found.clear();
  if (count == 0) return;
  search(
      0, points_.size(), to,
      [&](const Entry& e) { best.offer((e.position - to).squaredNorm(), e.index); },
      [&] { return best.reach(); });
  std::sort_heap(best.heap.begin(), best.heap.end());
  for (const auto& [square, index] : best.heap) found.push_back(index);
}

}  // namespace cloudcontact
