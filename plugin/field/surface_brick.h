// What a field's builder notes of the surface in one brick of the cloud: its voxels, their pieces,
// and in which pass of the edge search each came to them. With the passes known, a cut body's field
// is renewed where the cut reaches and nowhere else (field_renewal.cpp).
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include "kernels/contact/surface_fit.h"

#include <array>
#include <cstdint>
#include <vector>

namespace cloudcontact {

// One smooth piece of surface, seen from its voxel's centre.
struct SurfacePiece {
  CcSurface surface;
  float centroid[3];  // of the piece inside its voxel, grid frame
  float area;         // of it [voxel^2]; 0: the plane only bounds another piece
};

enum class PieceRule : std::uint8_t { Smooth, Convex, Concave };

// The pieces that a voxel had after a pass that changed them. Pass 0 is the quadric's fit.
struct VoxelStep {
  std::uint32_t first = 0;    // into pieces
  std::int16_t earlier = -1;  // the voxel's step before; -1: none
  std::uint8_t count = 0;
  std::uint8_t pass = 0;
  PieceRule rule = PieceRule::Smooth;
};

// A voxel that the surface crosses.
struct SurfaceVoxel {
  std::int16_t cell = 0;  // in the brick
  std::int16_t last = 0;  // its latest step
};

// A voxel's pieces as they stood at some time; nothing where the surface does not cross it.
struct VoxelState {
  const VoxelStep* step = nullptr;
  const SurfacePiece* pieces = nullptr;

  explicit operator bool() const { return step != nullptr; }
  int count() const { return step->count; }
  PieceRule rule() const { return step->rule; }
};
// True where nothing that reads a state could tell one from the other. Areas are read only when
// all passes are done.
bool same(const VoxelState& a, const VoxelState& b);

constexpr int kAfterAll = 255;  // later than any pass

struct SurfaceBrick {
  std::vector<SurfaceVoxel> voxels;  // by cell
  std::vector<VoxelStep> steps;
  std::vector<SurfacePiece> pieces;
  std::array<std::int16_t, kBrickVoxels> place;  // cell -> voxels, -1: not a surface voxel

  SurfaceBrick() { place.fill(-1); }
  // Step of a voxel before a pass, -1: none.
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
  // Adds a step with room for its pieces; returns its number.
  std::int16_t addStep(VoxelStep step);
  void findPlaces();  // `place`, from voxels
  void compact();     // without steps and pieces that no voxel leads to
};

}  // namespace cloudcontact
