// Settings and report of digitize().
#pragma once

#include <cstddef>
#include <functional>

namespace cloudcontact {

struct DigitizeSettings {
  double voxelSize = 0;                         // edge of a voxel [m], must be set
  std::size_t maxBytes = std::size_t{4} << 30;  // limit of memory
  int threads = 0;                              // 0: all cores
  std::function<void(double)> progress;         // receives 0..1; may be empty
};

// How well a mesh bounded a volume.
struct DigitizeReport {
  bool closed = false;  // the welded and repaired surface has no boundary
  // Columns in which the surface is not closed: a cap closes it, or, where large parts are missing,
  // the columns along the other axes and the winding number decide.
  std::size_t badColumns = 0;
  std::size_t undecidedVoxels = 0;  // voxels that the winding number had to decide
};

}  // namespace cloudcontact
