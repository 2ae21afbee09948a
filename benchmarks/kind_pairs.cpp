// The other kinds, each by the way that suits it: points one by one, columns interval by interval,
// trees from their roots.
#include "kind_pairs.h"

#include <cmath>

namespace cloudcontact {

namespace {

using Eigen::Vector3i;
using Voxels = FoundVoxels;

Voxels sorted(Voxels voxels) {
  const auto before = [](const VoxelIndex& a, const VoxelIndex& b) {
    if (a.z() != b.z()) return a.z() < b.z();
    return a.y() != b.y() ? a.y() < b.y() : a.x() < b.x();
  };
  std::sort(voxels.begin(), voxels.end(), before);
  voxels.erase(std::unique(voxels.begin(), voxels.end()), voxels.end());
  return voxels;
}

// The voxels of the workpiece whose coverage at a point of the tool is above 0.
template <typename Coverage>
Voxels pointsIn(const PointCloud& tool, const Pose& place, const Vec3& origin, double voxel,
                const Vector3i& size, Coverage&& coverage) {
  Voxels found;
  const Vec3 top = size.cast<double>();
  for (const Vec3& point : tool.positions) {
    const Vec3 grid = (place.toWorld(point) - origin) / voxel;
    if (!((grid.array() >= 0).all() && (grid.array() < top.array()).all())) continue;
    const Vector3i v = grid.cast<int>();
    if (coverage(v) > 0) found.emplace_back(v);
  }
  return sorted(std::move(found));
}

// The range of voxels whose centers lie in a box of the workpiece's frame, inside the grid.
struct Range {
  Eigen::Vector3i low, high;
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

struct TreePair {
  const SphereTree& tool;
  const Pose& place;  // of the tool in the workpiece
  const Cloud& work;
  Voxels found;

  bool holds(const SphereTree::Leaf& leaf, const Vec3& point) const {
    const Vec3 p = place.toLocal(point) - leaf.center;
    return leaf.share >= 0.5f && p.cwiseAbs().maxCoeff() <= halfEdge(leaf);
  }
  // Voxels with material whose centers lie in the leaf.
  void fill(const SphereTree::Leaf& leaf) {
    const Vec3 center = (place.toWorld(leaf.center) - work.origin()) / work.voxelSize();
    const double reach = leaf.radius / work.voxelSize();
    const Vector3i low = (center.array() - reach - 0.5).ceil().cast<int>().max(0);
    const Vector3i high = (center.array() + reach - 0.5).floor().cast<int>();
    const Vector3i top = high.cwiseMin(work.size() - Vector3i::Ones());
    for (int z = low.z(); z <= top.z(); ++z)
      for (int y = low.y(); y <= top.y(); ++y)
        for (int x = low.x(); x <= top.x(); ++x)
          if (work.coverage(x, y, z) > 0 && holds(leaf, work.center(x, y, z)))
            found.emplace_back(x, y, z);
  }
};

// Both trees at once: pairs of nodes whose spheres touch.
void descend(TreePair& pair, const SphereTree& other, std::uint32_t a, std::uint32_t b,
             std::vector<char>& isTouched) {
  const SphereTree::Node &n = pair.tool.nodes()[a], &m = other.nodes()[b];
  const double reach = n.radius + m.radius;
  if (isTouched[a] && n.second == 0) return;
  if ((pair.place.toWorld(n.center) - m.center).squaredNorm() > reach * reach) return;
  if (n.second == 0 && m.second == 0) {
    isTouched[a] = 1;
    return pair.fill(pair.tool.leaves()[n.leaf]);
  }
  if (m.second == 0 || (n.second != 0 && n.radius > m.radius)) {
    descend(pair, other, a + 1, b, isTouched);
    descend(pair, other, n.second, b, isTouched);
  } else {
    descend(pair, other, a, b + 1, isTouched);
    descend(pair, other, a, m.second, isTouched);
  }
}

// A tree against columns: a node goes on where a column beside it holds material.
bool meetsColumns(const ColumnCloud& c, const Vec3& center, double radius) {
  const int w = c.axis, u = (w + 1) % 3, v = (w + 2) % 3;
  const Vec3 p = center - c.origin;
  const auto from = [&](int a) { return std::floor((p[a] - radius) / c.width); };
  const auto to = [&](int a) { return std::floor((p[a] + radius) / c.width); };
  const int u0 = std::max(0, int(from(u))), u1 = std::min(c.columns.x() - 1, int(to(u)));
  const int v0 = std::max(0, int(from(v))), v1 = std::min(c.columns.y() - 1, int(to(v)));
  for (int b = v0; b <= v1; ++b)
    for (int a = u0; a <= u1; ++a) {
      const auto k = std::size_t(a + c.columns.x() * b);
      for (std::size_t i = c.first[k]; i < c.first[k + 1]; ++i)
        if (c.intervals[i].low <= p[w] + radius && c.intervals[i].high >= p[w] - radius)
          return true;
    }
  return false;
}

void descend(TreePair& pair, const ColumnCloud& columns, std::uint32_t a) {
  const SphereTree::Node& n = pair.tool.nodes()[a];
  // A large node is opened without a test: it would read too many columns.
  const bool isSmall = n.radius < 8 * columns.width;
  if (isSmall && !meetsColumns(columns, pair.place.toWorld(n.center), n.radius)) return;
  if (n.second == 0) return pair.fill(pair.tool.leaves()[n.leaf]);
  descend(pair, columns, a + 1);
  descend(pair, columns, n.second);
}

}  // namespace

double halfEdge(const SphereTree::Leaf& leaf) {
  return leaf.radius / std::sqrt(3.0);
}

Voxels pointsInOctree(const PointCloud& tool, const Pose& place, const Octree& work) {
  return pointsIn(tool, place, work.origin(), work.voxelSize(), work.size(),
                  [&](const Vector3i& v) { return work.at(v).coverage; });
}

Voxels pointsInVoxels(const PointCloud& tool, const Pose& place, const Cloud& work) {
  return pointsIn(tool, place, work.origin(), work.voxelSize(), work.size(),
                  [&](const Vector3i& v) { return work.coverage(v.x(), v.y(), v.z()); });
}

Voxels columnsInColumns(const ColumnCloud& tool, const Pose& toolPlace,
                        const ColumnCloud& workpiece) {
  const Columns in(tool);
  const int w = workpiece.axis, u = (w + 1) % 3, v = (w + 2) % 3;
  const double width = workpiece.width;
  double highest = 0;
  for (const ColumnInterval& i : workpiece.intervals) highest = std::max(highest, i.high);
  Eigen::Vector3i size;
  size[u] = workpiece.columns.x(), size[v] = workpiece.columns.y();
  size[w] = static_cast<int>(std::ceil(highest / width));
  const Range range = voxelsIn(placed(in.bounds(), toolPlace), workpiece.origin, width, size);
  Voxels found;
  VoxelIndex at;
  for (at[v] = range.low[v]; at[v] <= range.high[v]; ++at[v])
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
  return sorted(std::move(found));
}

Voxels treeInTree(const SphereTree& tool, const Pose& place, const SphereTree& workTree,
                  const Cloud& work) {
  TreePair pair{tool, place, work, {}};
  std::vector<char> isTouched(tool.nodes().size(), 0);
  descend(pair, workTree, 0, 0, isTouched);
  return sorted(std::move(pair.found));
}

Voxels treeInColumns(const SphereTree& tool, const Pose& place, const ColumnCloud& columns,
                     const Cloud& work) {
  TreePair pair{tool, place, work, {}};
  descend(pair, columns, 0);
  return sorted(std::move(pair.found));
}

}  // namespace cloudcontact
