// How a field is built from a cloud, a step a file:
//   field_fit.cpp     each voxel that the surface crosses gets the quadric of its 3x3x3 block
//   field_edges.cpp   those whose quadric does not explain the block get the planes of an edge
//   field_samples.cpp the pieces of surface inside each voxel become samples
//   field_band.cpp    voxels beside the surface inherit the nearest pieces
// All lengths in voxels, positions in the grid's frame (voxel (0,0,0) spans [0,1]^3).
#pragma once

#include <cloudcontact/surface_field.h>

#include "brick_grid.h"
#include "field_voxel.h"

#include <span>
#include <vector>

namespace cloudcontact {

// One smooth piece of surface, seen from its voxel's centre.
struct SurfacePiece {
  CcSurface surface;
  float centroid[3];  // of the piece inside its voxel, grid frame
  float area;         // of it [voxel^2]; 0: the plane only bounds another piece
};

enum class PieceRule : std::uint8_t { Smooth, Convex, Concave };

// A voxel that the surface crosses.
struct SurfaceVoxel {
  std::int16_t x, y, z;
  PieceRule rule = PieceRule::Smooth;
  std::uint32_t first = 0, count = 0;  // into pieces
  std::uint32_t quadric = 0;           // the piece that its block's quadric became
};

struct FieldDraft {
  const Cloud& cloud;
  FieldSettings settings;
  std::vector<SurfaceVoxel> voxels;
  std::vector<SurfacePiece> pieces;
  BrickGrid<std::int32_t> index;  // voxel -> its place in `voxels`, -1: not a surface voxel
};

// The coverage of the 3x3x3 block about a voxel, 0..1.
void gatherBlock(const Cloud& cloud, int x, int y, int z, float* coverage);

void fitSurfaceVoxels(FieldDraft& draft);
void resolveEdges(FieldDraft& draft);
std::vector<SurfaceSample> cutSamples(FieldDraft& draft);

// The finished band: what a query reads. In its bricks a voxel without a plane is far outside, or,
// where its `b` is this, deeper inside than the band reaches.
constexpr std::uint32_t kDeepInside = 1;
struct Band {
  BrickGrid<CcVoxel> grid;
  std::vector<CcVoxel> planes;
  std::size_t voxels = 0;
};
Band spreadBand(const FieldDraft& draft);

}  // namespace cloudcontact
