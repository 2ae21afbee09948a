// Columns from clouds and back: see column_cloud.h.
//
// A column consists of cubic cells with a share of material each. Where a partial cell lies between
// a full and an empty one, the surface crosses the column, and the interval ends inside the cell.
// Other partial cells belong to walls along the column and become intervals with that share of the
// cross-section. Both keep the amount of material exactly.
#include <cloudcontact/voxels/column_cloud.h>
#include <cloudcontact/voxels/digitize.h>

#include <cmath>
#include <stdexcept>

#include "voxels/cloud_builder.h"
#include "voxels/local_surface.h"

namespace cloudcontact {

namespace {

using Eigen::Vector3i;

constexpr float kFull = 1 - 1e-5f, kEmpty = 1e-5f;  // tolerance of divideVoxel()

// The cells of one column in ascending order.
struct Cells {
  std::vector<float> share;
  std::vector<std::uint8_t> material;
};

// Appends `next`, merged with the last interval where they meet and have equal share and material.
void append(std::vector<ColumnInterval>& intervals, std::size_t begin, const ColumnInterval& next) {
  if (intervals.size() > begin) {
    ColumnInterval& last = intervals.back();
    if (last.high == next.low && last.share == next.share && last.material == next.material) {
      last.high = next.high;
      return;
    }
  }
  intervals.push_back(next);
}

void encode(const Cells& cells, double height, std::vector<ColumnInterval>& intervals) {
  const std::size_t begin = intervals.size(), n = cells.share.size();
  const auto shareAt = [&](std::size_t k) { return k < n ? cells.share[k] : 0; };  // -1 wraps
  for (std::size_t k = 0; k < n; ++k) {
    const float f = cells.share[k];
    if (f <= kEmpty) continue;
    const float below = shareAt(k - 1), above = shareAt(k + 1);
    ColumnInterval next{static_cast<double>(k) * height, static_cast<double>(k + 1) * height, f,
                        cells.material[k]};
    if (f >= kFull) {
      next.share = 1;
    } else if (below >= kFull && above <= kEmpty) {
      next.high = (static_cast<double>(k) + f) * height;
      next.share = 1;
    } else if (below <= kEmpty && above >= kFull) {
      next.low = (static_cast<double>(k + 1) - f) * height;
      next.share = 1;
    }
    append(intervals, begin, next);
  }
}

// Divides the voxels of one voxel column into its n x n columns of cells.
class VoxelColumn {
 public:
  VoxelColumn(const Cloud& cloud, int axis, int n)
      : cloud_(cloud), axis_(axis), n_(n), cells_(n * n) {
    const auto height = static_cast<std::size_t>(cloud.size()[axis]) * static_cast<std::size_t>(n);
    for (Cells& c : cells_) c.share.assign(height, 0), c.material.assign(height, 0);
  }

  // Fills the cells of voxel column (u, v); false where it is empty.
  bool fill(int u, int v) {
    bool any = false;
    Vector3i voxel;
    voxel[(axis_ + 1) % 3] = u, voxel[(axis_ + 2) % 3] = v;
    for (int w = 0; w < cloud_.size()[axis_]; ++w) {
      voxel[axis_] = w;
      const int own = cloud_.coverage(voxel[0], voxel[1], voxel[2]);
      any |= own > 0;
      if (own > 0 && own < 255)
        divideVoxel(cloud_, voxel, n_, shares_);
      else
        shares_.assign(n_ * n_ * n_, own > 0 ? 1.f : 0.f);
      put(w, cloud_.material(voxel[0], voxel[1], voxel[2]));
    }
    return any;
  }

  const Cells& cells(int i, int j) const { return cells_[i + n_ * j]; }

 private:
  void put(int w, std::uint8_t material) {
    for (int k = 0; k < n_ * n_ * n_; ++k) {
      const int at[3] = {k % n_, k / n_ % n_, k / (n_ * n_)};
      Cells& c = cells_[at[(axis_ + 1) % 3] + n_ * at[(axis_ + 2) % 3]];
      const auto cell = static_cast<std::size_t>(w * n_ + at[axis_]);
      c.share[cell] = shares_[k];
      c.material[cell] = material;
    }
  }
  const Cloud& cloud_;
  int axis_, n_;
  std::vector<Cells> cells_;
  std::vector<float> shares_;
};

}  // namespace

void validate(const ColumnCloud& c) {
  const auto fail = [](const std::string& why) { throw std::invalid_argument("columns: " + why); };
  if (c.axis < 0 || c.axis > 2) fail("axis must be 0, 1 or 2");
  if (!(c.width > 0) || !std::isfinite(c.width)) fail("width must be positive and finite [m]");
  if (!c.origin.allFinite()) fail("origin must be finite [m]");
  if ((c.columns.array() < 0).any()) fail("columns must not be negative");
  const std::size_t count = c.columns.cast<std::size_t>().prod();
  if (c.first.size() != count + 1 || c.first.front() != 0 || c.first.back() != c.intervals.size())
    fail("first must have an entry for each of the columns and one more, from 0 to the intervals");
  if (c.materials.size() > 256) fail("more than 256 materials");
  for (std::size_t k = 0; k < count; ++k) {
    if (c.first[k] > c.first[k + 1] || c.first[k + 1] > c.intervals.size())
      fail("first must not descend");
    for (std::size_t i = c.first[k]; i < c.first[k + 1]; ++i) {
      const ColumnInterval& a = c.intervals[i];
      if (!std::isfinite(a.low) || !std::isfinite(a.high) || !(a.low < a.high))
        fail("an interval's low must be under its high, both finite [m]");
      if (i > c.first[k] && a.low < c.intervals[i - 1].high) fail("intervals overlap");
      if (!(a.share > 0 && a.share <= 1)) fail("an interval's share must be above 0 and at most 1");
      if (a.material > 0 && a.material >= c.materials.size()) fail("an interval names no material");
    }
  }
}

ColumnCloud toColumns(const Cloud& cloud, int axis, int perVoxel) {
  if (axis < 0 || axis > 2) throw std::invalid_argument("toColumns: axis must be 0, 1 or 2");
  if (perVoxel < 1 || perVoxel > 64)
    throw std::invalid_argument("toColumns: perVoxel must be from 1 to 64");
  ColumnCloud columns;
  columns.axis = axis;
  columns.materials = cloud.materials();
  columns.first = {0};
  if (cloud.empty()) return columns;
  columns.width = cloud.voxelSize() / perVoxel;
  columns.origin = cloud.origin();
  const int nu = cloud.size()[(axis + 1) % 3], nv = cloud.size()[(axis + 2) % 3];
  columns.columns = {nu * perVoxel, nv * perVoxel};
  VoxelColumn column(cloud, axis, perVoxel);
  // One row of voxel columns at a time. It yields perVoxel rows of columns.
  std::vector<std::vector<ColumnInterval>> row(static_cast<std::size_t>(nu * perVoxel * perVoxel));
  for (int v = 0; v < nv; ++v) {
    for (auto& intervals : row) intervals.clear();
    for (int u = 0; u < nu; ++u) {
      if (!column.fill(u, v)) continue;
      for (int j = 0; j < perVoxel; ++j)
        for (int i = 0; i < perVoxel; ++i)
          encode(column.cells(i, j), columns.width, row[u * perVoxel + i + nu * perVoxel * j]);
    }
    for (const auto& intervals : row) {
      columns.intervals.insert(columns.intervals.end(), intervals.begin(), intervals.end());
      columns.first.push_back(columns.intervals.size());
    }
  }
  return columns;
}

ColumnCloud toColumns(const Mesh& mesh, double width, int axis) {
  DigitizeSettings settings;
  settings.voxelSize = width;
  return toColumns(digitize(mesh, settings), axis, 1);
}

Cloud toCloud(const ColumnCloud& columns, double voxelSize) {
  validate(columns);
  const int u = (columns.axis + 1) % 3, v = (columns.axis + 2) % 3, w = columns.axis;
  const auto boxOf = [&](std::size_t column, const ColumnInterval& i) {
    const auto n = static_cast<std::size_t>(columns.columns[0]);
    Vec3 low;
    low[u] = static_cast<double>(column % n) * columns.width;
    low[v] = static_cast<double>(column / n) * columns.width;
    Vec3 high = low + Vec3::Constant(columns.width);
    low[w] = i.low, high[w] = i.high;
    return Eigen::AlignedBox3d(columns.origin + low, columns.origin + high);
  };
  const auto forEach = [&](auto&& visit) {
    for (std::size_t c = 0; c + 1 < columns.first.size(); ++c)
      for (std::size_t i = columns.first[c]; i < columns.first[c + 1]; ++i)
        visit(boxOf(c, columns.intervals[i]), columns.intervals[i]);
  };
  Eigen::AlignedBox3d all;
  forEach([&](const Eigen::AlignedBox3d& box, const ColumnInterval&) { all.extend(box); });
  CloudBuilder builder(cloudGrid("columns", all, voxelSize, columns.origin), columns.materials);
  forEach([&](const Eigen::AlignedBox3d& box, const ColumnInterval& i) {
    builder.addBox(box.min(), box.max(), i.share, i.material);
  });
  return builder.build();
}

VoxelKind kindOf(const Cloud& cloud, const Vector3i& voxel) {
  const int c = cloud.coverage(voxel[0], voxel[1], voxel[2]);
  return c == 0 ? VoxelKind::Outside : c == 255 ? VoxelKind::Inside : VoxelKind::Interface;
}

VoxelSplit splitVoxels(const Cloud& cloud) {
  VoxelSplit split;
  forEachVoxel(cloud, [&](const Vector3i& voxel, int coverage) {
    (coverage == 255 ? split.inside : split.interface).push_back(voxel);
  });
  split.outside =
      cloud.size().cast<std::size_t>().prod() - split.inside.size() - split.interface.size();
  return split;
}

}  // namespace cloudcontact
