// Voxels of a surface with large missing parts.
//
// The surface is cut into columns along all three axes. A column whose sum does not return to zero
// passes through a hole or along a crack. Where all three columns through a voxel close and agree,
// they give its coverage. Elsewhere a column may enter and leave through holes, so the generalized
// winding number decides too. It tells inside from outside at points only, so a column that it
// confirms gives the better coverage, even one that does not quite close. Cracks much narrower than
// a voxel change no voxel.
#include "voxels/open_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/grid_index.h"
#include "base/parallel.h"
#include "mesh/winding.h"

namespace cloudcontact {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Votes agree up to this difference [1/255]: rounding makes 1, cracks a little more.
constexpr int kAgree = 8;
// Largest residue of a column that may still be confirmed by the winding number [1/255].
constexpr int kMostResidue = 16;
// Largest difference of a confirmed vote from the winding number [1/255]: from its samples across
// the voxel, and from its value at the center, which a surface may pass closely.
constexpr int kConfirmed = 64, kConfirmedAtCenter = 160;
// A winding number this far from 1/2 is clear: no hole is near.
constexpr double kClearShare = 0.35;
// Samples of the winding number along each edge of a voxel.
constexpr int kSamples = 4;

// The coverages that columns give a voxel, in ascending order.
struct Votes {
  int value[3], count = 0;
  void add(int coverage) {
    int i = count++;
    for (; i > 0 && value[i - 1] > coverage; --i) value[i] = value[i - 1];
    value[i] = coverage;
  }
  bool unanimous() const { return count == 3 && value[2] - value[0] <= kAgree; }
  int middle() const { return value[count / 2]; }
  // The vote nearest to `coverage`, where one is near; -1 otherwise.
  int confirmed(int coverage, int tolerance) const {
    int best = -1, least = tolerance + 1;
    for (int i = 0; i < count; ++i)
      if (const int off = std::abs(value[i] - coverage); off < least) least = off, best = value[i];
    return best;
  }
};

class Voter {
 public:
  Voter(const GridSurface& surface, const std::array<ColumnResult, 3>& axes)
      : axes_(axes), winding_(surface.vertices, surface.triangles), bricks_(surface.bricks) {}

  // Computes the coverage of all voxels of brick `b`, entry `entry` of the table. Returns the
  // number of voxels that the winding number decided.
  std::size_t decide(const Vector3i& b, std::size_t entry, BrickCoverage& coverage) const {
    std::size_t undecided = 0;
    for (int v = 0; v < kBrickVoxels; ++v) {
      const Vector3i voxel = kBrickEdge * b + cellOffset(v);
      Votes closed, nearly;
      for (int k = 0; k < 3; ++k)
        if (const int left = residue(k, voxel); left <= kMostResidue)
          (left == 0 ? closed : nearly).add(coverageOf(k, entry, v));
      const bool plain = closed.unanimous();
      undecided += !plain;
      coverage[v] =
          static_cast<std::uint8_t>(plain ? closed.middle() : judged(voxel, closed, nearly));
    }
    return undecided;
  }

  // For a brick that no surface passes through: kSolidBrick or kEmptyBrick where its middle and its
  // corners are clearly inside or outside; 0 near a hole, where inside may end without a surface.
  std::int32_t uniform(const Vector3i& b) const {
    const Vector3d middle = kBrickEdge * (b.cast<double>() + Vector3d::Constant(0.5));
    const bool solid = winding_.at(middle) > 0.5;
    for (int i = 0; i < 9; ++i) {
      const Vector3d corner(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
      const double w = winding_.at(i < 8 ? Vector3d(middle + 0.5 * kBrickEdge * corner) : middle);
      if ((w > 0.5) != solid || std::abs(w - 0.5) < kClearShare) return 0;
    }
    return solid ? kSolidBrick : kEmptyBrick;
  }

  // Whether a brick is empty, or solid, along all axes and no column through it is bad.
  bool plain(const Vector3i& b, std::size_t entry) const {
    const std::int32_t code = axes_[0].voxels.table[entry];
    if (code >= 0) return false;
    for (int k = 0; k < 3; ++k) {
      if (axes_[k].voxels.table[entry] != code) return false;
      for (int i = 0; i < kBrickEdge * kBrickEdge && axes_[k].badColumns > 0; ++i) {
        Vector3i voxel = kBrickEdge * b;
        voxel[(k + 1) % 3] += i % kBrickEdge;
        voxel[(k + 2) % 3] += i / kBrickEdge;
        if (residue(k, voxel) > 0) return false;
      }
    }
    return true;
  }

 private:
  int residue(int axis, const Vector3i& voxel) const {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto width = static_cast<std::size_t>(bricks_[u] * kBrickEdge);
    return axes_[axis]
        .residue[static_cast<std::size_t>(voxel[u]) + width * static_cast<std::size_t>(voxel[v])];
  }

  int coverageOf(int axis, std::size_t entry, int v) const {
    const std::int32_t code = axes_[axis].voxels.table[entry];
    if (code < 0) return code == kSolidBrick ? 255 : 0;
    return axes_[axis].voxels.coverage[code][v];
  }

  // The coverage where the columns do not all agree.
  int judged(const Vector3i& voxel, const Votes& closed, const Votes& nearly) const {
    const double w = winding_.at(voxel.cast<double>() + Vector3d::Constant(0.5));
    if (std::abs(w - 0.5) > kClearShare) {
      const int whole = w > 0.5 ? 255 : 0;
      const int vote = closed.confirmed(whole, kConfirmedAtCenter);
      if (vote >= 0) return vote;
      if (nearly.count == 0) return whole;
    }
    const int samples = sampled(voxel);
    int vote = closed.confirmed(samples, kConfirmed);
    // Columns that do not close count only in voxels that the samples find partial, too.
    if (vote < 0 && samples > 0 && samples < 255) vote = nearly.confirmed(samples, kConfirmed);
    return vote >= 0 ? vote : samples;
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

// One layer of bricks in z. Layers are computed in parallel and joined in order.
struct Layer {
  std::vector<std::int32_t> table;
  std::vector<BrickCoverage> coverage;
  std::size_t undecided = 0;
};

Layer decideLayer(const Voter& voter, const Vector3i& bricks, int z,
                  const std::vector<std::int32_t>& plainTable, const std::vector<bool>& touched) {
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
      if (const std::int32_t code = touched[entry] ? 0 : voter.uniform(b); code < 0) {
        layer.undecided += kBrickVoxels;
        layer.table.push_back(code);
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
  const std::vector<bool> touched = touchedBricks(surface).touched;
  std::vector<Layer> layers(surface.bricks[2]);
  parallelFor(layers.size(), threads, [&](std::size_t z, int) {
    layers[z] =
        decideLayer(voter, surface.bricks, static_cast<int>(z), axes[0].voxels.table, touched);
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
