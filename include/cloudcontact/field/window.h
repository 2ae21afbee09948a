// The cuttable area C and its representative point Gr, cut into a workpiece's voxels. Paper,
// Step 5, Figs. 7 and 8 (docs/method.md, "Step 5: direction").
#pragma once

#include <cloudcontact/law/solid.h>

#include <cstdint>
#include <vector>

namespace cloudcontact {

// How voxels in C count.
enum class WindowWeight : std::uint8_t {
  Even,   // each voxel by how much of it lies in C: the paper's
  Smooth  // that times (1 - (1 - s)^2)^2, where s is the depth in C over the greatest depth. On a
          // plane 0.39 deg off instead of 0.63
};

// C around a voxel whose center is the origin. Any shape, size and offset [m].
struct WindowSettings {
  PlacedSolid area;
  WindowWeight weight = WindowWeight::Even;
  // Gr: the end point of every base vector. Its distance from the center of gravity of a full
  // window is a constant bias of all base vectors (paper, Discussion).
  Vec3 representative = Vec3::Zero();
};

// A smooth sphere around the voxel with Gr at its center. Radius 2.5 has the least error for its
// cost.
WindowSettings sphereWindow(double voxelSize, double radiusInVoxels = 2.5);

// One voxel of the window; x, y, z count from its middle voxel.
struct WindowTap {
  std::int16_t x, y, z;
  std::uint8_t weight;  // [1/255] of a voxel
  // Weight times the center of the voxel's part inside C [1/255 voxel^2]. Where the surface of C
  // cuts the voxel, that is not the voxel's center.
  std::int32_t moment[3];
};

struct Window {
  std::vector<WindowTap> taps;  // x fastest
  Vec3 representative;          // [voxels]
  Eigen::Vector3i low, high;    // bounds of the taps
  std::int64_t weights = 0;     // sum over the taps
  Vec3 center() const;          // center of gravity of a full window [voxels]
};

// Throws std::invalid_argument where C has no volume or is too small to hold part of a voxel, and
// std::length_error where it holds over 2^18 voxels or reaches over 2^13 voxels away.
Window makeWindow(const WindowSettings& settings, double voxelSize);

}  // namespace cloudcontact
