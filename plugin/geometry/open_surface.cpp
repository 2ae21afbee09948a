// Voxels of a surface that lacks much of itself.
//
// Such a surface is cut into columns along all three axes. A column whose sum does not come back to
// zero passes through a hole, or along a crack, and has no say. For each voxel the columns that
// pass through it and did close are compared: where two agree they decide, and where only one
// closed it does. Where they contradict each other (a column may enter and leave through holes and
// close on nothing), or none closed, the generalised winding number decides: it is the smoothest
// answer that a surface with holes has. Cracks much narrower than a voxel change no voxel.
#include "geometry/open_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/parallel.h"
#include "geometry/winding.h"

namespace cloudcontact {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Votes that differ by no more agree [1/255]. Rounding makes 1, cracks a little more.
constexpr int kAgree = 8;
// Winding numbers are sampled at so many places along each edge of a voxel.
constexpr int kSamples = 4;

class Voter {
 public:
  Voter(const GridSurface& surface, const std::array<ColumnResult, 3>& axes)
      : axes_(axes), winding_(surface.vertices, surface.triangles), bricks_(surface.bricks) {}

  // Coverage of all voxels of brick `b`, its place in the table being `entry`; returns how many
  // the winding number decided.
  std::size_t decide(const Vector3i& b, std::size_t entry, BrickCoverage& coverage) const {
    std::size_t undecided = 0;
    for (int v = 0; v < kBrickVoxels; ++v) {
      const Vector3i voxel = kBrickEdge * b + Vector3i(v % 8, v / 8 % 8, v / 64);
      int said[3], count = 0;
      for (int k = 0; k < 3; ++k)
        if (!bad(k, voxel)) said[count++] = coverageOf(k, entry, v);
      if (count > 1 && said[1] < said[0]) std::swap(said[0], said[1]);
      if (count > 2 && said[2] < said[1]) std::swap(said[1], said[2]);
      if (count > 1 && said[1] < said[0]) std::swap(said[0], said[1]);
      int decision = agreed(said, count);
      if (decision < 0) {
        decision = sampled(voxel);
        ++undecided;
      }
      coverage[static_cast<std::size_t>(v)] = static_cast<std::uint8_t>(decision);
    }
    return undecided;
  }

  // Whether all axes say that a brick is the same, empty or solid, and no column through it is bad.
  bool plain(const Vector3i& b, std::size_t entry) const {
    const std::int32_t code = axes_[0].voxels.table[entry];
    if (code >= 0) return false;
    for (int k = 0; k < 3; ++k) {
      if (axes_[k].voxels.table[entry] != code) return false;
      for (int i = 0; i < kBrickEdge * kBrickEdge && axes_[k].badColumns > 0; ++i) {
        Vector3i voxel = kBrickEdge * b;
        voxel[(k + 1) % 3] += i % kBrickEdge;
        voxel[(k + 2) % 3] += i / kBrickEdge;
        if (bad(k, voxel)) return false;
      }
    }
    return true;
  }

 private:
  bool bad(int axis, const Vector3i& voxel) const {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto width = static_cast<std::size_t>(bricks_[u] * kBrickEdge);
    return axes_[axis].bad[static_cast<std::size_t>(voxel[u]) +
                           width * static_cast<std::size_t>(voxel[v])] != 0;
  }

  int coverageOf(int axis, std::size_t entry, int v) const {
    const std::int32_t code = axes_[axis].voxels.table[entry];
    if (code < 0) return code == kSolidBrick ? 255 : 0;
    return axes_[axis].voxels.coverage[static_cast<std::size_t>(code)][static_cast<std::size_t>(v)];
  }

  // What the sorted votes agree on, -1 where they do not.
  static int agreed(const int* said, int count) {
    if (count == 1) return said[0];
    for (int i = 0; i + 1 < count; ++i) {
      // Of three, the closer pair.
      if (count == 3 && i == 0 && said[2] - said[1] < said[1] - said[0]) continue;
      if (said[i + 1] - said[i] <= kAgree) return (said[i] + said[i + 1] + 1) / 2;
    }
    return -1;
  }

  int sampled(const Vector3i& voxel) const {
    int inside = 0;
    const auto at = [&](int i, int n) {
      const Vector3d place(i % n + 0.5, i / n % n + 0.5, i / (n * n) + 0.5);
      return winding_.at(voxel.cast<double>() + place / n) > 0.5;
    };
    for (int i = 0; i < 8; ++i) inside += at(i, 2);
    if (inside == 0 || inside == 8) return inside == 0 ? 0 : 255;
    constexpr int kAll = kSamples * kSamples * kSamples;
    inside = 0;
    for (int i = 0; i < kAll; ++i) inside += at(i, kSamples);
    return (255 * inside + kAll / 2) / kAll;
  }

  const std::array<ColumnResult, 3>& axes_;
  WindingTree winding_;
  Vector3i bricks_;
};

// One layer of bricks in z, so that layers can be decided in parallel and joined in their order.
struct Layer {
  std::vector<std::int32_t> table;
  std::vector<BrickCoverage> coverage;
  std::size_t undecided = 0;
};

Layer decideLayer(const Voter& voter, const Vector3i& bricks, int z,
                  const std::vector<std::int32_t>& plainTable) {
  Layer layer;
  std::size_t entry = static_cast<std::size_t>(z) * bricks[0] * bricks[1];
  BrickCoverage coverage;
  for (int y = 0; y < bricks[1]; ++y)
    for (int x = 0; x < bricks[0]; ++x, ++entry) {
      const Vector3i b(x, y, z);
      if (voter.plain(b, entry)) {
        layer.table.push_back(plainTable[entry]);
        continue;
      }
      layer.undecided += voter.decide(b, entry, coverage);
      const auto [least, most] = std::minmax_element(coverage.begin(), coverage.end());
      if (*most == 0 || *least == 255) {
        layer.table.push_back(*most == 0 ? kEmptyBrick : kSolidBrick);
      } else {
        layer.table.push_back(static_cast<std::int32_t>(layer.coverage.size()));
        layer.coverage.push_back(coverage);
      }
    }
  return layer;
}

}  // namespace

Vote voteOnColumns(const GridSurface& surface, int threads,
                   const std::function<void(double)>& progress) {
  Vote vote;
  std::array<ColumnResult, 3> axes;
  for (int k = 0; k < 3; ++k) {
    axes[k] = cutColumns(surface, k, threads, [&](double done) {
      if (progress) progress((k + done) / 4);
    });
    vote.badColumns += axes[k].badColumns;
  }
  const Voter voter(surface, axes);
  std::vector<Layer> layers(static_cast<std::size_t>(surface.bricks[2]));
  parallelFor(layers.size(), threads, [&](std::size_t z, int) {
    layers[z] = decideLayer(voter, surface.bricks, static_cast<int>(z), axes[0].voxels.table);
  });
  vote.voxels.bricks = surface.bricks;
  for (Layer& layer : layers) {
    const auto base = static_cast<std::int32_t>(vote.voxels.coverage.size());
    for (const std::int32_t b : layer.table) vote.voxels.table.push_back(b < 0 ? b : base + b);
    vote.voxels.coverage.insert(vote.voxels.coverage.end(), layer.coverage.begin(),
                                layer.coverage.end());
    vote.undecidedVoxels += layer.undecided;
    layer = Layer();
  }
  if (progress) progress(1);
  return vote;
}

}  // namespace cloudcontact
