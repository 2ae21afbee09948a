// SurfaceSample: a piece of a cloud's surface, used as a quadrature point (docs/force.md,
// "Samples").
#pragma once

namespace cloudcontact {

// All lengths in voxels, positions in the frame of the cloud's grid (origin at the grid's corner).
struct SurfaceSample {
  float position[3];  // on the surface
  float normal[3];    // outward unit vector, fitted to the coverage
  float area;         // of the surface that it represents [voxel^2]
  float width;        // edge of a square with the same spread; depth varies over it [voxels]
};

}  // namespace cloudcontact
