// PointTree: a k-d tree over points. Equal points give equal trees and equal results.
#pragma once

#include <cloudcontact/base/pose.h>

#include <cstdint>
#include <vector>

namespace cloudcontact {

class PointTree {
 public:
  // Copies the points. All must be finite.
  explicit PointTree(const std::vector<Vec3>& points);

  bool empty() const { return points_.empty(); }

  // Index of the nearest point; of equally near ones always the same. The tree must not be empty.
  std::size_t nearest(const Vec3& to) const;

  // Indices of the `count` nearest points, or of all where there are fewer, nearest first.
  void nearest(const Vec3& to, std::size_t count, std::vector<std::size_t>& found) const;

  // Calls visit(index, squared distance) for every point within `radius` [m], in a fixed order.
  template <typename Visit>
  void forEachWithin(const Vec3& of, double radius, Visit&& visit) const {
    if (!empty() && radius >= 0) within(0, points_.size(), of, radius * radius, visit);
  }

 private:
  static constexpr std::size_t kLeaf = 8;
  struct Entry {
    Vec3 position;
    std::uint32_t index;
    std::uint32_t axis;  // that this entry splits, where it is the middle of a node
  };
  struct Best;
  void build(std::size_t first, std::size_t last);
  template <typename Test, typename Reach>
  void search(std::size_t first, std::size_t last, const Vec3& to, Test&& test,
              Reach&& reach) const;

  template <typename Visit>
  void within(std::size_t first, std::size_t last, const Vec3& of, double square,
              Visit& visit) const {
    const auto test = [&](const Entry& e) {
      const double d = (e.position - of).squaredNorm();
      if (d <= square) visit(e.index, d);
    };
    if (last - first <= kLeaf) {
      for (std::size_t i = first; i < last; ++i) test(points_[i]);
      return;
    }
    const std::size_t middle = first + (last - first) / 2;
    const Entry& e = points_[middle];
    const double side = of[e.axis] - e.position[e.axis];
    if (side <= 0 || side * side <= square) within(first, middle, of, square, visit);
    test(e);
    if (side >= 0 || side * side <= square) within(middle + 1, last, of, square, visit);
  }

  std::vector<Entry> points_;
};

}  // namespace cloudcontact
