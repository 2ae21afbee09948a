// Fourth step of the field: the layers of the band, how far each voxel lies from the surface, and
// which pieces of it are nearest. A voxel inherits pieces from its neighbors in the layers before
// its own, so a change travels from layer to layer and ends where a voxel's pieces stay the same.
#pragma once

#include "field/field_draft.h"

#include <array>
#include <compare>
#include <cstdint>
#include <memory>
#include <vector>

namespace cloudcontact {

constexpr int kInsideLayers = 5;   // depth is known this far below the surface [voxels]
constexpr int kOutsideLayers = 2;  // samples feel a surface before they cross it (smoothed depth)
constexpr int kLayers = kInsideLayers > kOutsideLayers ? kInsideLayers : kOutsideLayers;
constexpr int kKept = 4;  // pieces that a voxel passes on

// Names a piece: the pass that found it, its voxel, and its number there. Of two equally near
// pieces the lower key comes first.
class PieceKey {
 public:
  PieceKey() = default;
  PieceKey(int pass, const Eigen::Vector3i& v, int number)
      : bits_(std::uint64_t(pass) << 48 | part(v.z() >> 3, 36) | part(v.y() >> 3, 24) |
              part(v.x() >> 3, 12) | part(cellIndex(v), 3) | part(number, 0)) {}

  int number() const { return field(0, 3); }
  int cell() const { return field(3, 9); }
  Eigen::Vector3i brick() const { return {field(12, 12), field(24, 12), field(36, 12)}; }
  Eigen::Vector3i voxel() const { return kBrickEdge * brick() + cellOffset(cell()); }
  auto operator<=>(const PieceKey&) const = default;

 private:
  static std::uint64_t part(int value, int at) { return static_cast<std::uint64_t>(value) << at; }
  int field(int at, int bits) const { return static_cast<int>(bits_ >> at & ((1u << bits) - 1)); }

  std::uint64_t bits_ = 0;
};

struct BandCell {
  PieceKey piece[kKept];
  std::int8_t count = 0;
  std::int8_t layer = -1;  // 0: surface voxel; 1, 2, ... away from it on both sides; -1: none
};
using BandCells = std::array<BandCell, kBrickVoxels>;
using LayerBricks = std::vector<std::shared_ptr<const BandCells>>;  // null: no voxel in the band

// A piece relative to a voxel's center.
struct NearPiece {
  PieceKey key;
  PieceRule rule;
  float distance2;  // squared distance to the piece's centroid
  float depth;      // of the center below the piece's surface
  Eigen::Vector3f normal, centroid;
  float drop;  // dropOf(surface)
};
NearPiece nearPiece(const FieldDraft& draft, PieceKey key, const Eigen::Vector3f& center);

// The mean of a curved surface over a voxel (variance 1/12 each way) lies this much below its
// center. With it, samples spread over the voxel read the right depth on average.
inline float dropOf(const CcSurface& f) {
  return (f.k11 + f.k22) * (1.0f / 24.0f);
}

class FieldLayers {
 public:
  // `before`: of an earlier field of the same grid, shared until written to; or none.
  explicit FieldLayers(const FieldDraft& draft, LayerBricks before = {});

  const LayerBricks& bricks() const { return bricks_; }
  const BandCell& at(const Eigen::Vector3i& v) const;  // an empty one outside the grid

  void spread();  // from all surface voxels
  // After changes: `pieces` appeared, disappeared or changed; `turned` became less than half full,
  // or more. Returns the voxels whose records these reach.
  VoxelSet renew(const VoxelSet& pieces, const VoxelSet& turned);

 private:
  class Renewal;
  using Voxels = std::vector<Eigen::Vector3i>;

  // The 27 cells around a voxel, x fastest.
  struct Around {
    const BandCell* cell[27];
  };
  Around around(const Eigen::Vector3i& v) const;
  BandCell& write(const Eigen::Vector3i& v);
  void seed(const Eigen::Vector3i& v, const VoxelState& state);
  int reachOf(const Eigen::Vector3i& v) const;
  // Gives the layer after that of `from` to their neighbors that have none.
  Voxels grow(const Voxels& from, int layer);
  void inherit(const Voxels& voxels);
  BandCell inherited(const Around& around, const Eigen::Vector3i& v) const;

  const FieldDraft& draft_;
  const Eigen::Vector3i size_;  // in bricks
  LayerBricks bricks_;
  std::vector<BandCells*> own_;  // null: shared or missing
};

}  // namespace cloudcontact
