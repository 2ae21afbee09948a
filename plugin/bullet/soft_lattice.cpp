// Cells and nodes.
//
// Whole cells fill the bounds of the matter. A cell counts where matter fills a quarter of it. Each
// voxel is shared out over the cells that it meets, and its mass over the nodes of its cell by how
// near they are, so the body's mass and its center are those of the cloud. Where a cell at the
// surface is partly full, its outer nodes move onto the surface.
//
// Stiffness of a link: a lattice of equal cells with edges a, b, c has the elastic constants of a
// solid with Poisson's ratio 1/4, C11 = 1.2 E and C12 = C44 = 0.4 E, where the springs of one cell
// are, along an edge a, E bc/a (1.2 - 0.4 (a^2/b^2 + a^2/c^2)) / 4, and along a diagonal of the
// face ab, 0.2 E c (a^2 + b^2) / (ab) / 2 (born of the sums of k L^2 n n n n over a cell's links).
// Links of several cells add up. E is that of two half links in series, each with its node's.
#include "bullet/soft_lattice.h"

#include <cloudcontact/voxels/voxel_cut.h>

#include <cloudcontact/law/law.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

namespace cloudcontact {

namespace {

constexpr double kLeastFill = 0.25;  // of a cell that counts
constexpr double kFull = 0.98;       // of a cell whose nodes stay where they are
constexpr double kMostNodes = 2e5;
constexpr double kMidway = 1e-6;  // [cells] a voxel this near to the middle is halved

// Equal boxes over the bounds of the matter.
struct Boxes {
  VoxelIndex count = VoxelIndex::Ones();
  Vec3 low = Vec3::Zero(), edge = Vec3::Zero();
  std::size_t cellAt(const VoxelIndex& i) const {
    return static_cast<std::size_t>((i.z() * count.y() + i.y()) * count.x() + i.x());
  }
  std::size_t nodeAt(const VoxelIndex& i) const {
    return static_cast<std::size_t>((i.z() * (count.y() + 1) + i.y()) * (count.x() + 1) + i.x());
  }
  bool holds(const VoxelIndex& i) const {
    return (i.array() >= 0).all() && (i.array() < count.array()).all();
  }
  std::size_t nodes() const { return nodeAt(count) + 1; }
  Vec3 place(const VoxelIndex& i) const { return low + edge.cwiseProduct(i.cast<double>()); }
};

VoxelIndex corner(int bits) {
  return {bits & 1, bits >> 1 & 1, bits >> 2 & 1};
}

// Calls visit(x, y, z, coverage in 0..1) for all voxels with matter.
template <class Visit>
void visitMatter(const Cloud& cloud, const Visit& visit) {
  const VoxelIndex size = cloud.size();
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x)
        if (const int c = cloud.coverage(x, y, z); c > 0) visit(VoxelIndex(x, y, z), c / 255.0);
}

// The matter's bounds. The outermost layer of voxels counts as far as its fullest one.
Eigen::AlignedBox3d matterBounds(const Cloud& cloud) {
  Eigen::AlignedBox3i box;
  visitMatter(cloud, [&](const VoxelIndex& v, double) { box.extend(v); });
  if (box.isEmpty()) throw std::invalid_argument("SoftTissue: the cloud holds no matter");
  Vec3 lowFill = Vec3::Zero(), highFill = Vec3::Zero();
  visitMatter(cloud, [&](const VoxelIndex& v, double share) {
    for (int e = 0; e < 3; ++e) {
      if (v[e] == box.min()[e]) lowFill[e] = std::max(lowFill[e], share);
      if (v[e] == box.max()[e]) highFill[e] = std::max(highFill[e], share);
    }
  });
  const double h = cloud.voxelSize();
  Vec3 low = box.min().cast<double>() + Vec3::Ones() - lowFill;
  Vec3 high = box.max().cast<double>() + highFill;
  for (int e = 0; e < 3; ++e)
    if (box.min()[e] == box.max()[e]) low[e] = box.min()[e], high[e] = low[e] + 1;
  return {cloud.origin() + h * low, cloud.origin() + h * high};
}

// What multiplies E for an edge of a cell, with the other two edges.
double edgeFactor(const Vec3& edge, int axis) {
  const double a = edge[axis], b = edge[(axis + 1) % 3], c = edge[(axis + 2) % 3];
  return b * c / a * (1.2 - 0.4 * (a * a / (b * b) + a * a / (c * c))) / 4;
}

// Long or flat cells would need springs that push where they are stretched.
bool areSprings(const Vec3& edge) {
  return edgeFactor(edge, 0) >= 0 && edgeFactor(edge, 1) >= 0 && edgeFactor(edge, 2) >= 0;
}

// In thin matter cells are smaller than asked for, so that they are nearly cubes.
Boxes boxesOf(const Cloud& cloud, double spacing) {
  if (!(spacing >= cloud.voxelSize()) || !std::isfinite(spacing))
    throw std::invalid_argument(
        "SoftTissueSettings::spacing must be finite and no less than a voxel of the cloud [m]");
  const Eigen::AlignedBox3d bounds = matterBounds(cloud);
  for (double most = spacing;; most *= 0.97) {
    const Vec3 cells = (bounds.sizes() / most).array().round().max(1);
    const Vec3 edge = bounds.sizes().cwiseQuotient(cells);
    if (!((cells + Vec3::Ones()).prod() <= kMostNodes))
      throw std::invalid_argument(
          "SoftTissueSettings::spacing gives more than 200,000 nodes; take a larger one, or matter "
          "that is not so thin");
    if (areSprings(edge)) return {cells.cast<int>(), bounds.min(), edge};
  }
}

// The matter in a cell.
struct Fill {
  double share = 0;            // of the cell that is full
  Vec3 middle = Vec3::Zero();  // of the matter, times the share [m]
};

std::vector<Fill> fillOf(const Cloud& cloud, const Boxes& boxes) {
  std::vector<Fill> fill(static_cast<std::size_t>(boxes.count.prod()));
  const double h = cloud.voxelSize(), perCell = h * h * h / boxes.edge.prod();
  visitMatter(cloud, [&](const VoxelIndex& v, double share) {
    const Vec3 low = (cloud.origin() + h * v.cast<double>() - boxes.low).cwiseQuotient(boxes.edge);
    const Vec3 width = h * boxes.edge.cwiseInverse();
    VoxelIndex first = low.array().floor().cast<int>();
    Vec3 ofFirst;  // the share of the voxel in its first cell along each axis
    for (int e = 0; e < 3; ++e) {
      ofFirst[e] = std::clamp((first[e] + 1 - low[e]) / width[e], 0.0, 1.0);
      if (first[e] < 0) first[e] = 0, ofFirst[e] = 1;
      if (first[e] + 1 >= boxes.count[e]) first[e] = boxes.count[e] - 1, ofFirst[e] = 1;
    }
    for (int bits = 0; bits < 8; ++bits) {
      const VoxelIndex step = corner(bits);
      double part = share * perCell;
      for (int e = 0; e < 3; ++e) part *= step[e] ? 1 - ofFirst[e] : ofFirst[e];
      if (!(part > 0)) continue;
      Fill& cell = fill[boxes.cellAt(first + step)];
      cell.share += part;
      cell.middle += part * cloud.center(v.x(), v.y(), v.z());
    }
  });
  return fill;
}

// Links of two nodes with what multiplies their E.
using LinkSums = std::map<std::pair<int, int>, std::pair<double, int>>;

void addLinks(const SoftCell& cell, const Vec3& edge, double fill, LinkSums& sums) {
  for (int i = 0; i < 8; ++i)
    for (int e = 0; e < 3; ++e) {
      const int f = (e + 1) % 3, g = (e + 2) % 3;
      const double a = edge[e], b = edge[f], c = edge[g];
      const auto add = [&](int j, int axis, double factor) {
        const int from = cell.nodes[static_cast<std::size_t>(i)],
                  to = cell.nodes[static_cast<std::size_t>(j)];
        auto& sum = sums[std::minmax(from, to)];
        sum.first += fill * factor;
        sum.second = axis;
      };
      if (!(i >> e & 1)) add(i | 1 << e, e, edgeFactor(edge, e));
      // Both diagonals of the face ab, from its two corners of lower e.
      if (!(i >> e & 1)) add(i ^ (1 << e | 1 << f), -1, 0.1 * c * (a * a + b * b) / (a * b));
    }
}

// The matter of a node.
struct NodeSums {
  double mass = 0;  // [kg] shared out by how near it is
  // Volume of each tissue [m^3] in the cells around, shared out likewise, and of that nearer to
  // this node than to others.
  std::vector<double> around, nearest;
};

class Builder {
 public:
  Builder(const Cloud& cloud, const TissueTable& tissues, double spacing)
      : cloud_(cloud),
        tissues_(tissues),
        boxes_(boxesOf(cloud, spacing)),
        fill_(fillOf(cloud, boxes_)),
        number_(boxes_.nodes(), -1) {}

  SoftLattice build() {
    lattice_.cell = boxes_.edge;
    makeCells();
    shareMatter();
    makeLinks();
    return std::move(lattice_);
  }

 private:
  bool counts(const VoxelIndex& cell) const {
    return boxes_.holds(cell) && fill_[boxes_.cellAt(cell)].share >= kLeastFill;
  }
  // Calls visit(index) for all cells that count.
  template <class Visit>
  void visitCells(const Visit& visit) const {
    for (int z = 0; z < boxes_.count.z(); ++z)
      for (int y = 0; y < boxes_.count.y(); ++y)
        for (int x = 0; x < boxes_.count.x(); ++x)
          if (counts({x, y, z})) visit(VoxelIndex(x, y, z));
  }
  int tissueOf(const VoxelIndex& v) const {
    return tissues_.size() > 1 ? cloud_.material(v.x(), v.y(), v.z()) : 0;
  }

  void makeCells();
  Vec3 nodePlace(const VoxelIndex& node) const;
  double fullness(const Vec3& place) const;
  bool shareVoxel(const VoxelIndex& v, double volume);
  NodeMatter meansOf(const NodeSums& sums) const;
  void shareMatter();
  void makeLinks();

  const Cloud& cloud_;
  const TissueTable& tissues_;
  Boxes boxes_;
  std::vector<Fill> fill_;      // of each cell
  std::vector<NodeSums> sums_;  // of each node
  std::vector<int> number_;     // of each place in the lattice, or -1
  SoftLattice lattice_;
};

void Builder::makeCells() {
  visitCells([&](const VoxelIndex& at) {
    for (int i = 0; i < 8; ++i) number_[boxes_.nodeAt(at + corner(i))] = 0;
  });
  const VoxelIndex n = boxes_.count;
  for (int z = 0; z <= n.z(); ++z)
    for (int y = 0; y <= n.y(); ++y)
      for (int x = 0; x <= n.x(); ++x) {
        int& number = number_[boxes_.nodeAt({x, y, z})];
        if (number < 0) continue;
        number = static_cast<int>(lattice_.places.size());
        lattice_.places.push_back(nodePlace({x, y, z}));
      }
  if (lattice_.places.empty())
    throw std::invalid_argument(
        "SoftTissueSettings::spacing: no cell of that size is full by a quarter; take a smaller "
        "one");
  visitCells([&](const VoxelIndex& at) {
    SoftCell cell;
    for (int i = 0; i < 8; ++i)
      cell.nodes[static_cast<std::size_t>(i)] = number_[boxes_.nodeAt(at + corner(i))];
    for (int face = 0; face < 6; ++face)
      cell.open[static_cast<std::size_t>(face)] =
          !counts(at + (face % 2 ? 1 : -1) * VoxelIndex::Unit(face / 2));
    lattice_.cells.push_back(cell);
  });
}

// Linear between the centers of voxels.
double Builder::fullness(const Vec3& place) const {
  const Vec3 grid = (place - cloud_.origin()) / cloud_.voxelSize() - Vec3::Constant(0.5);
  const VoxelIndex low = grid.array().floor().cast<int>();
  const Vec3 part = grid - low.cast<double>();
  double sum = 0;
  for (int bits = 0; bits < 8; ++bits) {
    const VoxelIndex v = low + corner(bits);
    double weight = cloud_.coverage(v.x(), v.y(), v.z()) / 255.0;
    for (int e = 0; e < 3; ++e) weight *= (bits >> e & 1) ? part[e] : 1 - part[e];
    sum += weight;
  }
  return sum;
}

// Where cells around are partly full or missing: on the surface, along the line from the middle of
// the matter around.
Vec3 Builder::nodePlace(const VoxelIndex& node) const {
  const Vec3 place = boxes_.place(node);
  Vec3 middle = Vec3::Zero();
  double all = 0;
  bool whole = true;
  int cells = 0;
  for (int i = 0; i < 8; ++i) {
    const VoxelIndex at = node - corner(i);
    if (!counts(at)) continue;
    const Fill& fill = fill_[boxes_.cellAt(at)];
    whole = whole && fill.share >= kFull;
    middle += fill.middle;
    all += fill.share;
    ++cells;
  }
  if (whole || cells == 8) return place;
  middle /= all;
  const Vec3 way = place - middle;
  const int steps = static_cast<int>(std::ceil(1.5 * way.norm() / (0.25 * cloud_.voxelSize())));
  double last = 0;
  for (int k = 1; k <= steps; ++k)
    if (const double t = 1.5 * k / steps; fullness(middle + t * way) >= 0.5) last = t;
  return last > 0 ? Vec3(middle + last * way) : place;
}

// Adds a voxel's matter to the nodes of its cell. False: its cell and those beside it do not count.
bool Builder::shareVoxel(const VoxelIndex& v, double volume) {
  const Vec3 grid = (cloud_.center(v.x(), v.y(), v.z()) - boxes_.low).cwiseQuotient(boxes_.edge);
  const VoxelIndex low = grid.array().floor().cast<int>().max(0).min(boxes_.count.array() - 1);
  const Vec3 part = (grid - low.cast<double>()).array().max(0).min(1);
  double linear[8], nearest[8], known = 0;
  for (int i = 0; i < 8; ++i) {
    linear[i] = nearest[i] = number_[boxes_.nodeAt(low + corner(i))] < 0 ? 0 : 1;
    for (int e = 0; e < 3; ++e) {
      const double near = (i >> e & 1) ? part[e] : 1 - part[e];
      linear[i] *= near;
      nearest[i] *= std::abs(near - 0.5) < kMidway ? 0.5 : std::round(near);
    }
    known += linear[i];
  }
  if (!(known > 0)) return false;
  const auto tissue = static_cast<std::size_t>(tissueOf(v));
  for (int i = 0; i < 8; ++i) {
    if (!(linear[i] > 0)) continue;
    NodeSums& node = sums_[static_cast<std::size_t>(number_[boxes_.nodeAt(low + corner(i))])];
    node.mass += linear[i] / known * volume * tissues_[tissue].density;
    node.around[tissue] += linear[i] / known * volume;
    node.nearest[tissue] += nearest[i] * volume;
  }
  return true;
}

// k, c and elasticity are those of the matter in the box of a cell's size about the node; where
// there is none, of that in the cells around it.
NodeMatter Builder::meansOf(const NodeSums& sums) const {
  NodeMatter matter;
  const bool any =
      std::any_of(sums.nearest.begin(), sums.nearest.end(), [](double v) { return v > 0; });
  const std::vector<double>& volumes = any ? sums.nearest : sums.around;
  double volume = 0, most = 0;
  for (std::size_t t = 0; t < tissues_.size(); ++t) {
    volume += volumes[t];
    matter.stiffness += volumes[t] * tissues_[t].stiffness;
    matter.damping += volumes[t] * tissues_[t].damping;
    matter.elasticity += volumes[t] * tissues_[t].elasticity;
    if (volumes[t] > most) most = volumes[t], matter.tissue = static_cast<int>(t);
  }
  matter.mass = sums.mass;
  matter.stiffness /= volume, matter.damping /= volume, matter.elasticity /= volume;
  return matter;
}

// Masses, and means by (1) and (2).
void Builder::shareMatter() {
  const std::vector<double> none(tissues_.size());
  sums_.assign(lattice_.places.size(), {0, none, none});
  double here = 0, all = 0;  // [kg]
  const double h = cloud_.voxelSize(), cubic = h * h * h;
  visitMatter(cloud_, [&](const VoxelIndex& v, double share) {
    const double mass = share * cubic * tissues_[static_cast<std::size_t>(tissueOf(v))].density;
    all += mass;
    if (shareVoxel(v, share * cubic)) here += mass;
  });
  for (const NodeSums& sums : sums_) {
    lattice_.matter.push_back(meansOf(sums));
    lattice_.matter.back().mass *= all / here;
  }
}

void Builder::makeLinks() {
  LinkSums sums;
  std::size_t k = 0;
  visitCells([&](const VoxelIndex& at) {
    addLinks(lattice_.cells[k++], boxes_.edge, std::min(1.0, fill_[boxes_.cellAt(at)].share), sums);
  });
  for (const auto& [nodes, sum] : sums) {
    const auto half = [&](int node) {  // [Pa, Pa s] of half the length
      const NodeMatter& m = lattice_.matter[static_cast<std::size_t>(node)];
      return KelvinVoigt{2 * m.elasticity, 2 * m.elasticity * m.damping / m.stiffness};
    };
    const auto [a, b] = nodes;
    const KelvinVoigt both = *inSeries(half(a), half(b));
    const auto& places = lattice_.places;
    const double length =
        (places[static_cast<std::size_t>(a)] - places[static_cast<std::size_t>(b)]).norm();
    lattice_.links.push_back(
        {a, b, length, sum.first * both.stiffness, sum.first * both.damping, sum.second});
  }
}

}  // namespace

SoftLattice softLattice(const Cloud& cloud, const TissueTable& tissues, double spacing) {
  return Builder(cloud, tissues, spacing).build();
}

}  // namespace cloudcontact
