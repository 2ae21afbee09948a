// The cuttable area C and its representative point Gr, cut into the voxels of a workpiece.
// Paper, Step 5, Figs. 7 and 8.
#pragma once

#include <cloudcontact/law/solid.h>

#include <cstdint>
#include <vector>

namespace cloudcontact {

enum class WindowWeight : std::uint8_t {
  Even,   // each voxel by how much of it lies in C: the paper's
  Smooth  // that times (1 - (1 - s)^2)^2, s the depth in C over its greatest: on a plane 0.39 deg
          // off instead of 0.63 (DESIGN.md, "The method", 2)
};

// C about a voxel whose centre is the origin [m]. Of any shape, size and offset.
struct WindowSettings {
  PlacedSolid area;
  WindowWeight weight = WindowWeight::Even;
  // Gr: where every base vector points to. Any place: its distance from the centre of gravity of
  // a window full of matter is a constant bias of every base vector (paper, Discussion).
  Vec3 representative = Vec3::Zero();
};

// A smooth sphere of 2.5 voxels about the voxel, Gr its centre: the least error for its cost.
WindowSettings sphereWindow(double voxelSize, double radiusInVoxels = 2.5);

// One voxel of the window, seen from its middle voxel.
struct WindowTap {
  std::int16_t x, y, z;
  std::uint8_t weight;  // 1/255 of a voxel
  // The weight times the place of that part of the voxel which lies in C [1/255 voxel^2]: a voxel
  // cut by C's surface is not weighed at its centre.
  std::int32_t moment[3];
};

struct Window {
  std::vector<WindowTap> taps;  // x fastest
  Vec3 representative;          // [voxels]
  Eigen::Vector3i low, high;    // of the taps
  std::int64_t weights = 0;     // their sum
  Vec3 center() const;          // of gravity, where all is matter [voxels]
};

// Throws std::invalid_argument where C has no volume or holds no voxel's part, std::length_error
// where it holds more than 2^18 voxels or lies more than 2^13 voxels away.
Window makeWindow(const WindowSettings& settings, double voxelSize);

}  // namespace cloudcontact
