// Coarse levels for large contacts: a search uses no more samples than it needs. Of a cell's
// samples that face the same way, the one nearest to their centroid represents all, with their area
// and mean normal. It keeps its own plane and width: averaged samples are wider and flatter than
// any piece of the surface, and make the M16 thread three times as deep.
#include "field/sample_set.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace cloudcontact {

namespace {

constexpr float kAlike = 0.95f;  // cosine: 18 deg; depth is not linear across larger angles
constexpr int kBrickBits = 18;   // of a brick's index along an axis
constexpr int kCellBits = 3;     // of a cell's octant in the next coarser cell

using V3 = Eigen::Vector3f;
using Key = std::uint64_t;

Eigen::Map<const V3> positionOf(const SurfaceSample& s) {
  return Eigen::Map<const V3>(s.position);
}

// Brick, then 4-voxel cell within it, then 2-voxel cell within that: sorting by it yields runs.
Key keyOf(const SurfaceSample& s) {
  constexpr int kMiddle = 1 << (kBrickBits - 1);  // pieces may lie a little outside the grid
  Key brick = 0, four = 0, two = 0;
  for (int axis = 2; axis >= 0; --axis) {
    const int at = static_cast<int>(std::floor(s.position[axis])) + 8 * kMiddle;
    brick = brick << kBrickBits | static_cast<Key>(at >> 3);
    four = four << 1 | static_cast<Key>(at >> 2 & 1);
    two = two << 1 | static_cast<Key>(at >> 1 & 1);
  }
  return brick << 2 * kCellBits | four << kCellBits | two;
}

struct Keyed {
  Key key;
  CutSample piece;

  Key brick() const { return key >> 2 * kCellBits; }
};

bool inOrder(const Keyed& a, const Keyed& b) {
  return a.key != b.key ? a.key < b.key : a.piece.origin.order < b.piece.origin.order;
}

using Pieces = std::span<const Keyed>;

std::vector<Keyed> sorted(const std::vector<CutSample>& pieces) {
  std::vector<std::pair<Key, std::uint32_t>> order(pieces.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    order[i] = {keyOf(pieces[i].sample), static_cast<std::uint32_t>(i)};
  std::sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first
                              : pieces[a.second].origin.order < pieces[b.second].origin.order;
  });
  std::vector<Keyed> keyed(pieces.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    keyed[i] = {order[i].first, pieces[order[i].second]};
  return keyed;
}

// Calls visit(begin, end) for each run of pieces whose keys agree above `shift` bits.
template <typename Visit>
void forEachRun(Pieces pieces, int shift, Visit&& visit) {
  for (std::size_t begin = 0, end = 0; begin < pieces.size(); begin = end) {
    while (end < pieces.size() && pieces[end].key >> shift == pieces[begin].key >> shift) ++end;
    visit(static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end));
  }
}

// Samples of a cell that face the same way.
struct Group {
  V3 vector = V3::Zero();  // sum of area times normal
  V3 facing = V3::Zero();  // the same, of length 1
  V3 first = V3::Zero();   // sum of area times position
  float area = 0;
  std::vector<std::uint32_t> members;

  void add(const SurfaceSample& s, std::uint32_t index) {
    vector += s.area * Eigen::Map<const V3>(s.normal);
    facing = vector.normalized();
    first += s.area * positionOf(s);
    area += s.area;
    members.push_back(index);
  }

  CcCluster cluster(Pieces pieces, const SurfaceSample& s) const;
  SurfaceSample sample(Pieces pieces) const {
    const V3 centroid = first / area;
    const auto distance = [&](std::uint32_t i) {
      return (positionOf(pieces[i].piece.sample) - centroid).squaredNorm();
    };
    const std::uint32_t nearest = *std::min_element(
        members.begin(), members.end(),
        [&](std::uint32_t a, std::uint32_t b) { return distance(a) < distance(b); });
    SurfaceSample s = pieces[nearest].piece.sample;
    s.area = vector.norm();
    // Moves to the centroid within its own plane. On a face along the grid, all four samples of a
    // cell are equally near; taking the first would shift a cube's center of force by 0.37 voxel.
    Eigen::Map<V3> position(s.position);
    const Eigen::Map<const V3> normal(s.normal);
    const V3 offset = centroid - position;
    position += offset - normal.dot(offset) * normal;
    // The mean normal, because the pieces' force points along the sum of their normals. Not moved
    // across its plane: at the centroid a screw locks late or early.
    Eigen::Map<V3>(s.normal) = vector.normalized();
    return s;
  }
};

// The cluster of `s`, which stands for the group. The ellipse has the shape of the members' spread
// over the plane, and is as large as holds them all. Of a disc of radius r about a member no point
// is farther from the ellipse's center than the member by more than r over the least half axis.
CcCluster Group::cluster(Pieces pieces, const SurfaceSample& s) const {
  float t1[3], t2[3];
  ccTangents(s.normal, t1, t2);
  const Eigen::Map<const V3> n(s.normal), u(t1), v(t2);
  const auto offset = [&](std::uint32_t i) {
    return V3(positionOf(pieces[i].piece.sample) - positionOf(s));
  };
  CcCluster cluster{0, {}};
  float uu = 1e-6f, uv = 0, vv = 1e-6f;
  for (const std::uint32_t i : members) {
    const SurfaceSample& m = pieces[i].piece.sample;
    const V3 by = offset(i);
    const float part = m.area / area, own = m.width * m.width / 12;
    const float cosine = n.dot(Eigen::Map<const V3>(m.normal));
    const float tilt = CC_HALF_WIDTH * m.width * std::sqrt(std::max(0.0f, 1 - cosine * cosine));
    cluster.rise = std::max(cluster.rise, n.dot(by) + tilt);
    uu += part * (u.dot(by) * u.dot(by) + own);
    uv += part * u.dot(by) * v.dot(by);
    vv += part * (v.dot(by) * v.dot(by) + own);
  }
  const float apart = 0.5f * (uu - vv);
  const float least = 0.5f * (uu + vv) - std::sqrt(apart * apart + uv * uv);
  float far = 0;
  for (const std::uint32_t i : members) {
    const float a = u.dot(offset(i)), b = v.dot(offset(i));
    const float square = (vv * a * a - 2 * uv * a * b + uu * b * b) / (uu * vv - uv * uv);
    const float disc = CC_HALF_WIDTH * pieces[i].piece.sample.width;
    far = std::max(far, std::sqrt(std::max(square, 0.0f)) + disc / std::sqrt(least));
  }
  for (int k = 0; k < 6; ++k) {
    const int row = k < 3 ? k : k < 5 ? 0 : 1, column = k < 3 ? k : k == 3 ? 1 : 2;
    cluster.spread[k] = far * far *
                        (uu * u[row] * u[column] + vv * v[row] * v[column] +
                         uv * (u[row] * v[column] + v[row] * u[column]));
  }
  return cluster;
}

// Assembles a set brick by brick.
class Assembler {
 public:
  explicit Assembler(std::vector<SampleOrigin>& origins) : origins_(origins) { origins_.clear(); }

  // Appends a brick from its sorted pieces.
  void add(Pieces pieces) {
    std::vector<std::uint32_t> firsts, ends;  // of cells: first sample on level 1, end in `pieces`
    forEachRun(pieces, 0, [&](std::uint32_t begin, std::uint32_t end) {
      firsts.push_back(samplesOf(1));
      group(pieces, begin, end);
      for (const Group& g : groups_) mergeLevel1(pieces, g);
      ends.push_back(end);
    });
    firsts.push_back(samplesOf(1));
    const std::uint32_t coarse = samplesOf(2);
    std::size_t fine = 0;
    forEachRun(pieces, kCellBits, [&](std::uint32_t begin, std::uint32_t end) {
      const std::uint32_t first = firsts[fine];
      while (fine < ends.size() && ends[fine] <= end) ++fine;
      group(pieces, begin, end);
      for (const Group& g : groups_) merge(set_.levels[2], pieces, g);
      set_.levels[2].finer.push_back({first, firsts[fine] - first});
    });
    addBrick(pieces, {coarse, samplesOf(2) - coarse});
  }

  // Appends bricks [from, to) of another set.
  void copy(const SampleSet& other, const std::vector<SampleOrigin>& origins, std::size_t from,
            std::size_t to);

  // Room for about as many samples as another set has.
  void reserveAs(const SampleSet& other) {
    const auto room = [](std::size_t count) { return count + count / 8; };
    origins_.reserve(room(other.levels[0].samples.size()));
    for (int level = 0; level < kLevels; ++level) {
      const SampleLevel& from = other.levels[level];
      set_.levels[level].samples.reserve(room(from.samples.size()));
      set_.levels[level].clusters.reserve(room(from.clusters.size()));
      set_.levels[level].cellOf.reserve(room(from.cellOf.size()));
      set_.levels[level].finer.reserve(room(from.finer.size()));
    }
  }

  SampleSet take() { return std::move(set_); }

 private:
  std::uint32_t samplesOf(int level) const {
    return static_cast<std::uint32_t>(set_.levels[level].samples.size());
  }

  // Finds the groups of the pieces [begin, end).
  void group(Pieces pieces, std::uint32_t begin, std::uint32_t end) {
    groups_.clear();
    for (std::uint32_t i = begin; i < end; ++i) {
      const SurfaceSample& s = pieces[i].piece.sample;
      const Eigen::Map<const V3> n(s.normal);
      const auto group = std::find_if(groups_.begin(), groups_.end(),
                                      [&](const Group& m) { return m.facing.dot(n) > kAlike; });
      (group == groups_.end() ? groups_.emplace_back() : *group).add(s, i);
    }
  }

  // Appends a group as a sample of the level's next cell.
  void merge(SampleLevel& level, Pieces pieces, const Group& group) {
    const SurfaceSample s = group.sample(pieces);
    level.samples.push_back(s);
    level.clusters.push_back(group.cluster(pieces, s));
    level.cellOf.push_back(static_cast<std::uint32_t>(level.finer.size()));
  }

  // On level 1 each group is a cell of its own, and its pieces are consecutive samples: where one
  // face of a cell is near, the others' pieces are not looked up.
  void mergeLevel1(Pieces pieces, const Group& group) {
    const std::uint32_t first = samplesOf(0);
    for (const std::uint32_t i : group.members) {
      set_.levels[0].samples.push_back(pieces[i].piece.sample);
      origins_.push_back(pieces[i].piece.origin);
    }
    merge(set_.levels[1], pieces, group);
    set_.levels[1].finer.push_back({first, samplesOf(0) - first});
  }

  void addBrick(Pieces pieces, SampleRun run) {
    Eigen::AlignedBox3f box;
    for (const Keyed& k : pieces) box.extend(positionOf(k.piece.sample));
    SampleBricks& bricks = set_.bricks;
    bricks.x.push_back(box.center().x());
    bricks.y.push_back(box.center().y());
    bricks.z.push_back(box.center().z());
    bricks.radius.push_back(0.5f * box.diagonal().norm());
    bricks.runs.push_back(run);
  }

  SampleSet set_;
  std::vector<SampleOrigin>& origins_;
  std::vector<Group> groups_;
};

// Numbers of samples and cells in all bricks before this one, on each level.
struct Offsets {
  std::uint32_t samples[kLevels], cells[kLevels];

  Offsets(const SampleSet& set, std::size_t brick) {
    const SampleLevel& coarsest = set.levels[kLevels - 1];
    const bool end = brick == set.bricks.runs.size();
    samples[kLevels - 1] =
        end ? static_cast<std::uint32_t>(coarsest.samples.size()) : set.bricks.runs[brick].first;
    for (int level = kLevels - 1; level > 0; --level) {
      const SampleLevel& l = set.levels[level];
      cells[level] = end ? static_cast<std::uint32_t>(l.finer.size()) : l.cellOf[samples[level]];
      samples[level - 1] = end ? static_cast<std::uint32_t>(set.levels[level - 1].samples.size())
                               : l.finer[cells[level]].first;
    }
    cells[0] = 0;
  }
};

void Assembler::copy(const SampleSet& other, const std::vector<SampleOrigin>& origins,
                     std::size_t from, std::size_t to) {
  if (from == to) return;
  const Offsets begin(other, from), end(other, to);
  std::uint32_t shift[kLevels];
  for (int level = 0; level < kLevels; ++level)
    shift[level] = samplesOf(level) - begin.samples[level];
  origins_.insert(origins_.end(), origins.begin() + begin.samples[0],
                  origins.begin() + end.samples[0]);
  for (int level = 0; level < kLevels; ++level) {
    SampleLevel& own = set_.levels[level];
    const SampleLevel& l = other.levels[level];
    const std::uint32_t cells = static_cast<std::uint32_t>(own.finer.size()) - begin.cells[level];
    own.samples.append(l.samples, begin.samples[level], end.samples[level] - begin.samples[level]);
    if (level == 0) continue;
    own.clusters.append(l.clusters, begin.samples[level],
                        end.samples[level] - begin.samples[level]);
    for (std::uint32_t i = begin.samples[level]; i < end.samples[level]; ++i)
      own.cellOf.push_back(l.cellOf[i] + cells);
    for (std::uint32_t i = begin.cells[level]; i < end.cells[level]; ++i)
      own.finer.push_back({l.finer[i].first + shift[level - 1], l.finer[i].count});
  }
  SampleBricks& own = set_.bricks;
  const SampleBricks& bricks = other.bricks;
  for (std::size_t i = from; i < to; ++i) {
    own.x.push_back(bricks.x[i]);
    own.y.push_back(bricks.y[i]);
    own.z.push_back(bricks.z[i]);
    own.radius.push_back(bricks.radius[i]);
    own.runs.push_back({bricks.runs[i].first + shift[kLevels - 1], bricks.runs[i].count});
  }
}

// A brick's samples without those of removed voxels, in their order.
std::vector<Keyed> remaining(const SampleSet& set, const std::vector<SampleOrigin>& origins,
                             const VoxelSet& removed, std::size_t brick) {
  std::vector<Keyed> left;
  const std::uint32_t end = Offsets(set, brick + 1).samples[0];
  for (std::uint32_t i = Offsets(set, brick).samples[0]; i < end; ++i) {
    if (removed.has(origins[i].brick, origins[i].cell)) continue;
    const SurfaceSample s = set.levels[0].samples[i];
    left.push_back({keyOf(s), {s, origins[i]}});
  }
  return left;
}

}  // namespace

namespace {

void appendTo(LargeVector<float>& to, const LargeVector<float>& source, std::size_t first,
              std::size_t count) {
  const auto begin = source.begin() + static_cast<std::ptrdiff_t>(first);
  to.insert(to.end(), begin, begin + static_cast<std::ptrdiff_t>(count));
}

}  // namespace

void SampleColumns::append(const SampleColumns& from, std::size_t first, std::size_t count) {
  const auto add = [&](LargeVector<float>& to, const LargeVector<float>& source) {
    appendTo(to, source, first, count);
  };
  add(x, from.x), add(y, from.y), add(z, from.z);
  add(nx, from.nx), add(ny, from.ny), add(nz, from.nz);
  add(area, from.area), add(width, from.width);
}

void SampleColumns::reserve(std::size_t count) {
  for (auto* column : {&x, &y, &z, &nx, &ny, &nz, &area, &width}) column->reserve(count);
}

void SampleColumns::fit(const SampleColumns& other) {
  reserve(other.x.capacity());
}

void SampleColumns::clear() {
  for (auto* column : {&x, &y, &z, &nx, &ny, &nz, &area, &width}) column->clear();
}

void ClusterColumns::push_back(const CcCluster& cluster) {
  rise.push_back(cluster.rise);
  for (int k = 0; k < 6; ++k) spread[k].push_back(cluster.spread[k]);
}

void ClusterColumns::append(const ClusterColumns& from, std::size_t first, std::size_t count) {
  appendTo(rise, from.rise, first, count);
  for (int k = 0; k < 6; ++k) appendTo(spread[k], from.spread[k], first, count);
}

void ClusterColumns::reserve(std::size_t count) {
  rise.reserve(count);
  for (LargeVector<float>& column : spread) column.reserve(count);
}

void ClusterColumns::clear() {
  rise.clear();
  for (LargeVector<float>& column : spread) column.clear();
}

SampleSet sortSamples(std::vector<CutSample> pieces, std::vector<SampleOrigin>& origins) {
  const std::vector<Keyed> keyed = sorted(pieces);
  Assembler assembler(origins);
  forEachRun(keyed, 2 * kCellBits, [&](std::uint32_t begin, std::uint32_t end) {
    assembler.add(Pieces(keyed).subspan(begin, end - begin));
  });
  return assembler.take();
}

SampleSet renewSamples(const SampleSet& before, const std::vector<SampleOrigin>& originsBefore,
                       const VoxelSet& removed, std::vector<CutSample> fresh,
                       std::vector<SampleOrigin>& origins) {
  const std::vector<Keyed> keyed = sorted(fresh);
  Assembler assembler(origins);
  assembler.reserveAs(before);
  auto next = keyed.begin();
  const auto freshEnd = [&](Key brick) {  // end of the fresh pieces in a brick
    auto end = next;
    while (end != keyed.end() && end->brick() == brick) ++end;
    return end;
  };
  std::size_t copied = 0;
  const std::size_t count = before.bricks.runs.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t first = Offsets(before, i).samples[0],
                        end = Offsets(before, i + 1).samples[0];
    const Key own = keyOf(before.levels[0].samples[first]) >> 2 * kCellBits;
    bool touched = next != keyed.end() && next->brick() <= own;
    for (std::uint32_t k = first; k < end && !touched; ++k)
      touched = removed.has(originsBefore[k].brick, originsBefore[k].cell);
    if (!touched) continue;
    assembler.copy(before, originsBefore, copied, i);
    copied = i + 1;
    while (next != keyed.end() && next->brick() < own) {
      const auto to = freshEnd(next->brick());
      assembler.add({next, to});
      next = to;
    }
    std::vector<Keyed> pieces = remaining(before, originsBefore, removed, i);
    const auto to = freshEnd(own);
    pieces.insert(pieces.end(), next, to);
    next = to;
    std::sort(pieces.begin(), pieces.end(), inOrder);
    if (!pieces.empty()) assembler.add(pieces);
  }
  assembler.copy(before, originsBefore, copied, count);
  forEachRun(Pieces(next, keyed.end()), 2 * kCellBits, [&](std::uint32_t begin, std::uint32_t end) {
    assembler.add(Pieces(next, keyed.end()).subspan(begin, end - begin));
  });
  return assembler.take();
}

std::size_t SampleSet::bytes() const {
  std::size_t sum = bricks.runs.size() * (4 * sizeof(float) + sizeof(SampleRun));
  for (const SampleLevel& level : levels)
    sum += level.samples.bytes() + level.clusters.size() * sizeof(CcCluster) +
           level.cellOf.size() * sizeof(std::uint32_t) + level.finer.size() * sizeof(SampleRun);
  return sum;
}

}  // namespace cloudcontact
