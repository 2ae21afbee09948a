// FieldDraft: a surface while its field is being built, as quadrics and planes per voxel.
//
// The steps that build a field, one file each:
//   field_fit      every voxel that the surface crosses gets the quadric of its 3x3x3 block
//   field_edges    where a quadric does not explain its block, several planes replace it
//   field_samples  the pieces of surface inside each voxel become samples
//   field_layers   voxels beside the surface inherit the nearest pieces, layer by layer
//   field_band     the records of these voxels
//   field_records  the band in the layout that searches read
// Each step looks only a few voxels far. After a cut, every step therefore runs on the affected
// voxels alone and gives there the same bits as a full build (surface_field.cpp, renewed()). The
// draft keeps the result of every pass of the edge search for that purpose.
//
// All lengths in voxels, positions in the grid's frame: voxel (0,0,0) spans [0,1]^3.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include "base/grid_index.h"
#include "kernels/contact/surface_fit.h"
#include "voxels/voxel_set.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace cloudcontact {

// A smooth piece of surface, relative to its voxel's center.
struct SurfacePiece {
  CcSurface surface;
  float centroid[3];  // of the piece inside its voxel, grid's frame
  float area;         // of the piece [voxel^2]; 0: the plane only bounds another piece
};

// How a voxel's pieces combine: one piece, intersection of half-spaces, or union.
enum class PieceRule : std::uint8_t { Smooth, Convex, Concave };

// A voxel's pieces after a pass that changed them. Pass 0 is the fit of the quadric.
struct VoxelStep {
  std::uint32_t first = 0;    // index of the first piece
  std::int16_t earlier = -1;  // the voxel's previous step; -1: none
  std::uint8_t count = 0;
  std::uint8_t pass = 0;
  PieceRule rule = PieceRule::Smooth;
};

// A voxel that the surface crosses.
struct SurfaceVoxel {
  std::int16_t cell = 0;  // in the brick
  std::int16_t last = 0;  // index of its latest step
};

// A voxel's pieces at some time; empty where the surface does not cross the voxel.
struct VoxelState {
  const VoxelStep* step = nullptr;
  const SurfacePiece* pieces = nullptr;

  explicit operator bool() const { return step != nullptr; }
  int count() const { return step->count; }
  PieceRule rule() const { return step->rule; }
};
// Compares what the edge search reads: surfaces, not areas, which are computed after all passes.
bool same(const VoxelState& a, const VoxelState& b);

constexpr int kAfterAll = 255;  // later than any pass

// The surface inside one brick of the cloud.
struct SurfaceBrick {
  std::vector<SurfaceVoxel> voxels;  // sorted by cell
  std::vector<VoxelStep> steps;
  std::vector<SurfacePiece> pieces;
  std::array<std::int16_t, kBrickVoxels> place;  // index into voxels by cell; -1: none
  std::uint16_t passes = 0;                      // that may have made a step, one bit each

  SurfaceBrick() { place.fill(-1); }
  // Index of a voxel's last step before a pass; -1: none.
  int stepBefore(int voxel, int pass) const {
    int step = voxels[static_cast<std::size_t>(voxel)].last;
    while (step >= 0 && steps[static_cast<std::size_t>(step)].pass >= pass)
      step = steps[static_cast<std::size_t>(step)].earlier;
    return step;
  }
  VoxelState stateAt(int step) const {
    const VoxelStep& s = steps[static_cast<std::size_t>(step)];
    return {&s, pieces.data() + s.first};
  }
  VoxelState state(int cell, int pass = kAfterAll) const {
    const int voxel = place[static_cast<std::size_t>(cell)];
    if (voxel < 0) return {};
    const int step = stepBefore(voxel, pass);
    return step < 0 ? VoxelState{} : stateAt(step);
  }
  // Appends a step with room for its pieces and returns its index.
  std::int16_t addStep(VoxelStep step);
  void findPlaces();  // recomputes `place` from `voxels`
  void compact();     // drops steps and pieces that no voxel refers to
};
using SurfaceBricks = std::vector<std::shared_ptr<const SurfaceBrick>>;

// A voxel of the grid and its place in its brick.
struct DraftVoxel {
  std::int32_t brick;
  std::int16_t cell;
  int x, y, z;

  Eigen::Vector3f center() const { return {float(x) + 0.5f, float(y) + 0.5f, float(z) + 0.5f}; }
};

class FieldDraft {
 public:
  // `before`: bricks of an earlier field of the same grid. They stay shared until written to.
  FieldDraft(const Cloud& wholeCloud, int threadsUsed,
             const std::function<void(double)>& spendOfSettings, SurfaceBricks before = {});

  const Cloud& cloud;
  const int threads;
  // Steps call it after each part of a renewal, with its cost (FieldSettings::spend).
  void spend(double cost) const {
    if (spend_) spend_(cost);
  }
  // Parts of a loop that come between two calls of spend(); `all` of them if nobody asks.
  std::size_t partsAtOnce(std::size_t some, std::size_t all) const { return spend_ ? some : all; }

  const SurfaceBrick* brick(std::size_t t) const { return bricks_[t].get(); }  // null: no surface
  const SurfaceBricks& bricks() const { return bricks_; }
  // The draft's own copy of a brick, created if missing. Threads may write to different bricks;
  // none may read a brick during its first write, which replaces it.
  SurfaceBrick& write(std::size_t t);
  void compact();                                   // compacts written bricks, drops empty ones
  std::vector<std::int32_t> surfaceBricks() const;  // bricks that have surface voxels, ascending
  Eigen::Vector3i cornerOf(std::size_t t) const;    // lowest voxel of a brick
  DraftVoxel voxelAt(std::int32_t brick, int cell) const;
  DraftVoxel voxelAt(int x, int y, int z) const;  // inside the grid
  // The brick that holds a voxel; null outside the grid and without surface.
  const SurfaceBrick* brickOf(int x, int y, int z) const {
    if (!insideGrid(x >> 3, y >> 3, z >> 3, size_)) return nullptr;
    return bricks_[brickIndex(x, y, z, size_)].get();
  }
  const SurfaceBrick* brickAt(const Eigen::Vector3i& b) const {  // inside the grid
    return bricks_[gridIndex(b, size_)].get();
  }
  // A voxel's pieces before a pass; empty outside the grid.
  VoxelState at(int x, int y, int z, int pass = kAfterAll) const {
    const SurfaceBrick* const b = brickOf(x, y, z);
    return b ? b->state(cellIndex(x, y, z), pass) : VoxelState{};
  }

 private:
  const std::function<void(double)>& spend_;
  Eigen::Vector3i size_;  // in bricks
  SurfaceBricks bricks_;
  std::vector<SurfaceBrick*> own_;  // null: shared or missing
};

}  // namespace cloudcontact
