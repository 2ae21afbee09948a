// Lists of voxels from arrays of Python (voxel_lists.h).
#include "python/voxel_lists.h"

#include <stdexcept>

namespace cloudcontact::python {

std::vector<VoxelIndex> voxelsFrom(const py::object& voxels) {
  const Integers rows = integersOf("voxels", voxels);
  if (!rows || rows.ndim() != 2 || rows.shape(1) != 3)
    throw std::invalid_argument("voxels: give an array of integers of the shape (n, 3)");
  std::vector<VoxelIndex> list;
  for (py::ssize_t i = 0; i < rows.shape(0); ++i)
    list.emplace_back(rows.at(i, 0), rows.at(i, 1), rows.at(i, 2));
  return list;
}

std::vector<VoxelCut> cutsFrom(const py::object& voxels, const py::object& coverage) {
  const std::vector<VoxelIndex> list = voxelsFrom(voxels);
  std::vector<VoxelCut> cuts;
  for (const VoxelIndex& voxel : list) cuts.push_back({voxel, 0});
  if (coverage.is_none()) return cuts;
  const Integers numbers = integersOf("coverage", coverage);
  const bool one = numbers && numbers.ndim() == 0;
  if (!numbers || (!one && (numbers.ndim() != 1 || numbers.size() != py::ssize_t(cuts.size()))))
    throw std::invalid_argument("coverage: give one number for each voxel, or one for all");
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const int value = numbers.data()[one ? 0 : i];
    if (value < 0 || value > 255)
      throw std::invalid_argument("coverage: is not in 0..255; give what remains in 1/255");
    cuts[i].coverage = static_cast<std::uint8_t>(value);
  }
  return cuts;
}

}  // namespace cloudcontact::python
