// Work is divided into slices, layers of voxels or runs of points, whose results are joined in
// order.
#include <cloudcontact/workpiece/interference.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/parallel.h"

namespace cloudcontact {

namespace {

using Voxels = std::vector<VoxelIndex>;

void validatePlace(const Pose& place) {
  if (!place.position.allFinite() || !place.orientation.coeffs().allFinite())
    throw std::invalid_argument("interference: the tool's place must be finite");
}

bool before(const VoxelIndex& a, const VoxelIndex& b) {
  if (a.z() != b.z()) return a.z() < b.z();
  return a.y() != b.y() ? a.y() < b.y() : a.x() < b.x();
}

// Calls find(slice, voxels) for each slice and joins the voxels found.
template <typename Find>
Voxels inSlices(std::size_t slices, int threads, Find&& find) {
  std::vector<Voxels> found(slices);
  parallelFor(slices, threads, [&](std::size_t k, int) { find(k, found[k]); });
  Voxels all;
  for (const Voxels& part : found) all.insert(all.end(), part.begin(), part.end());
  std::sort(all.begin(), all.end(), before);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

// The range of voxels whose centers lie in a box of the workpiece's frame, inside the grid.
struct Range {
  Eigen::Vector3i low, high;
  std::size_t layers() const {
    return (high.array() < low.array()).any() ? 0
                                              : static_cast<std::size_t>(high.z() - low.z() + 1);
  }
};

Range voxelsIn(const Eigen::AlignedBox3d& box, const Vec3& origin, double voxel,
               const Eigen::Vector3i& size) {
  if (box.isEmpty()) return {Eigen::Vector3i::Zero(), Eigen::Vector3i::Constant(-1)};
  const Vec3 top = size.cast<double>();
  const auto grid = [&](const Vec3& x) {
    return Vec3(((x - origin) / voxel - Vec3::Constant(0.5)).cwiseMax(-1.0).cwiseMin(top));
  };
  return {grid(box.min()).array().ceil().cast<int>().matrix().cwiseMax(0),
          grid(box.max()).array().floor().cast<int>().matrix().cwiseMin(size -
                                                                        Eigen::Vector3i::Ones())};
}

// Bounds of a placed box.
Eigen::AlignedBox3d placed(const Eigen::AlignedBox3d& box, const Pose& place) {
  Eigen::AlignedBox3d result;
  if (box.isEmpty()) return result;
  for (int k = 0; k < 8; ++k)
    result.extend(place.toWorld(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k))));
  return result;
}

// Voxels of the workpiece with material whose centers `inside` accepts.
template <typename Inside>
Voxels centersInside(const Cloud& workpiece, const Eigen::AlignedBox3d& box, int threads,
                     Inside&& inside) {
  if (workpiece.empty()) return {};
  const Range range = voxelsIn(box, workpiece.origin(), workpiece.voxelSize(), workpiece.size());
  return inSlices(range.layers(), threads, [&](std::size_t k, Voxels& found) {
    const int z = range.low.z() + static_cast<int>(k);
    for (int y = range.low.y(); y <= range.high.y(); ++y)
      for (int x = range.low.x(); x <= range.high.x(); ++x)
        if (workpiece.coverage(x, y, z) > 0 && inside(workpiece.center(x, y, z)))
          found.emplace_back(x, y, z);
  });
}

// Whether points lie in a tool's columns.
class Columns {
 public:
  explicit Columns(const ColumnCloud& c) : c_(c), u_((c.axis + 1) % 3), v_((c.axis + 2) % 3) {}

  bool contains(const Vec3& local) const {
    const Vec3 p = local - c_.origin;
    const double u = std::floor(p[u_] / c_.width), v = std::floor(p[v_] / c_.width);
    if (!(u >= 0 && v >= 0 && u < c_.columns.x() && v < c_.columns.y())) return false;
    const auto column = static_cast<std::size_t>(u) +
                        static_cast<std::size_t>(c_.columns.x()) * static_cast<std::size_t>(v);
    for (std::size_t k = c_.first[column]; k < c_.first[column + 1]; ++k) {
      const ColumnInterval& i = c_.intervals[k];
      if (i.share >= 0.5f && p[c_.axis] >= i.low && p[c_.axis] < i.high) return true;
    }
    return false;
  }
  Eigen::AlignedBox3d bounds() const {
    Eigen::AlignedBox3d box;
    for (int v = 0; v < c_.columns.y(); ++v)
      for (int u = 0; u < c_.columns.x(); ++u) {
        const std::size_t column = static_cast<std::size_t>(u + c_.columns.x() * v);
        if (c_.first[column] == c_.first[column + 1]) continue;
        Vec3 low, high;
        low[u_] = u * c_.width, high[u_] = low[u_] + c_.width;
        low[v_] = v * c_.width, high[v_] = low[v_] + c_.width;
        low[c_.axis] = c_.intervals[c_.first[column]].low;
        high[c_.axis] = c_.intervals[c_.first[column + 1] - 1].high;
        box.extend(Vec3(c_.origin + low)).extend(Vec3(c_.origin + high));
      }
    return box;
  }

 private:
  const ColumnCloud& c_;
  int u_, v_;
};

// Spheres in a grid of cells as wide as the largest, so that a point is tested against few.
class Spheres {
 public:
  Spheres(const SphereCloud& s, const Pose& place) {
    double largest = 0;
    for (const double r : s.radii) largest = std::max(largest, r);
    for (std::size_t k = 0; k < s.centers.size(); ++k) {
      const Vec3 center = place.toWorld(s.centers[k]);
      spheres_.push_back({center, s.radii[k], Eigen::Vector3i::Zero()});
      bounds_.extend(Vec3(center.array() - s.radii[k])).extend(Vec3(center.array() + s.radii[k]));
    }
    cell_ = std::max(2 * largest, bounds_.isEmpty() ? 0.0 : bounds_.sizes().maxCoeff() / 1024);
    for (Sphere& sphere : spheres_) sphere.cell = cellOf(sphere.center);
    std::sort(spheres_.begin(), spheres_.end(),
              [](const Sphere& a, const Sphere& b) { return before(a.cell, b.cell); });
  }
  const Eigen::AlignedBox3d& bounds() const { return bounds_; }

  bool contains(const Vec3& point) const {
    const Eigen::Vector3i at = cellOf(point);
    for (int k = 0; k < 9; ++k) {
      // Three cells along x are one run in the sorted list.
      const Eigen::Vector3i first = at + Eigen::Vector3i(-1, k % 3 - 1, k / 3 - 1);
      auto s = std::lower_bound(
          spheres_.begin(), spheres_.end(), first,
          [](const Sphere& sphere, const Eigen::Vector3i& c) { return before(sphere.cell, c); });
      const Eigen::Vector3i last = first + Eigen::Vector3i(2, 0, 0);
      for (; s != spheres_.end() && !before(last, s->cell); ++s)
        if ((point - s->center).squaredNorm() <= s->radius * s->radius) return true;
    }
    return false;
  }

 private:
  struct Sphere {
    Vec3 center;
    double radius;
    Eigen::Vector3i cell = Eigen::Vector3i::Zero();
  };
  Eigen::Vector3i cellOf(const Vec3& p) const {
    return ((p - bounds_.min()) / cell_).array().floor().cast<int>();
  }
  double cell_ = 1;
  Eigen::AlignedBox3d bounds_;
  std::vector<Sphere> spheres_;
};

}  // namespace

Voxels interference(const PointCloud& tool, const Pose& toolPlace, const Octree& workpiece,
                    int threads) {
  validatePlace(toolPlace);
  validate(tool);
  if (workpiece.empty()) return {};
  constexpr std::size_t kRun = 4096;  // points per slice
  const std::size_t slices = (tool.positions.size() + kRun - 1) / kRun;
  const Vec3 top = workpiece.size().cast<double>();
  return inSlices(slices, threads, [&](std::size_t k, Voxels& found) {
    const std::size_t end = std::min((k + 1) * kRun, tool.positions.size());
    for (std::size_t i = k * kRun; i < end; ++i) {
      const Vec3 local = toolPlace.toWorld(tool.positions[i]);
      const Vec3 grid = (local - workpiece.origin()) / workpiece.voxelSize();
      if (!((grid.array() >= 0).all() && (grid.array() < top.array()).all())) continue;
      const VoxelIndex voxel = grid.cast<int>();
      if (workpiece.at(voxel).coverage > 0) found.push_back(voxel);
    }
  });
}

Voxels interference(const ColumnCloud& tool, const Pose& toolPlace, const ColumnCloud& workpiece,
                    int threads) {
  validatePlace(toolPlace);
  validate(tool);
  validate(workpiece);
  const Columns in(tool);
  const int w = workpiece.axis, u = (w + 1) % 3, v = (w + 2) % 3;
  const double width = workpiece.width;
  double highest = 0;
  for (const ColumnInterval& i : workpiece.intervals) highest = std::max(highest, i.high);
  Eigen::Vector3i size;
  size[u] = workpiece.columns.x(), size[v] = workpiece.columns.y();
  size[w] = static_cast<int>(std::ceil(highest / width));
  const Range range = voxelsIn(placed(in.bounds(), toolPlace), workpiece.origin, width, size);
  if (range.layers() == 0) return {};
  // One slice per row of columns. Intervals are cut into voxels, whose centers are tested.
  const auto rows = static_cast<std::size_t>(range.high[v] - range.low[v] + 1);
  return inSlices(rows, threads, [&](std::size_t k, Voxels& found) {
    VoxelIndex at;
    at[v] = range.low[v] + static_cast<int>(k);
    for (at[u] = range.low[u]; at[u] <= range.high[u]; ++at[u]) {
      const auto column = static_cast<std::size_t>(at[u] + size[u] * at[v]);
      for (std::size_t i = workpiece.first[column]; i < workpiece.first[column + 1]; ++i) {
        const ColumnInterval& has = workpiece.intervals[i];
        if (has.share < 0.5f) continue;
        const int low = std::max(range.low[w], static_cast<int>(std::ceil(has.low / width - 0.5)));
        const int high =
            std::min(range.high[w], static_cast<int>(std::ceil(has.high / width - 0.5)) - 1);
        for (at[w] = low; at[w] <= high; ++at[w]) {
          const Vec3 center = workpiece.origin + width * (at.cast<double>() + Vec3::Constant(0.5));
          if (in.contains(toolPlace.toLocal(center))) found.push_back(at);
        }
      }
    }
  });
}

Voxels interference(const SphereCloud& tool, const Pose& toolPlace, const Cloud& workpiece,
                    int threads) {
  validatePlace(toolPlace);
  validate(tool);
  const Spheres spheres(tool, toolPlace);
  return centersInside(workpiece, spheres.bounds(), threads,
                       [&](const Vec3& center) { return spheres.contains(center); });
}

Voxels interference(const Cloud& tool, const Pose& toolPlace, const Cloud& workpiece, int threads) {
  validatePlace(toolPlace);
  if (tool.empty()) return {};
  const double h = tool.voxelSize();
  const Vec3 top = tool.size().cast<double>();
  const Eigen::AlignedBox3d box(tool.origin(), Vec3(tool.origin() + h * top));
  return centersInside(workpiece, placed(box, toolPlace), threads, [&](const Vec3& center) {
    const Vec3 grid = (toolPlace.toLocal(center) - tool.origin()) / h;
    if (!((grid.array() >= 0).all() && (grid.array() < top.array()).all())) return false;
    const Eigen::Vector3i v = grid.cast<int>();
    return tool.coverage(v.x(), v.y(), v.z()) >= 128;
  });
}

}  // namespace cloudcontact
