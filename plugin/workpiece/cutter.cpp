// Archard's volume, shared out in whole 255ths of a voxel: see cutter.h. What each voxel should
// lose is summed along the list of voxels, and a voxel loses what the sum's whole part grew by: no
// random numbers, no loss.
#include <cloudcontact/workpiece/cutter.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace cloudcontact {

// [1/255] that a voxel loses at once at least, unless less is left: each change concerns the 81
// voxels of a window, and in shavings of one, 60 a millisecond, cutting took a third of
// a tick.
constexpr int kLeast = 8;

CuttingProcess::CuttingProcess(const Cutter& cutter) : cutter_(cutter) {
  for (const double value : {cutter.hardness, cutter.efficiency, cutter.edgeSpeed})
    if (!(value >= 0) || !std::isfinite(value))
      throw std::invalid_argument(
          "Cutter: hardness, efficiency and edge speed must be zero or more and finite");
  if (cutter.mostVoxels < 1) throw std::invalid_argument("Cutter: mostVoxels must be positive");
}

CuttingProcess::Cut CuttingProcess::step(BaseVectorField& workpiece, const Collision& collision,
                                         double force, double speed, double seconds) {
  cuts_.clear();
  const double work = cutter_.efficiency * force * (cutter_.edgeSpeed + speed) * seconds;
  if (!(work > 0) || !std::isfinite(work) || collision.empty()) return {};
  const double h = workpiece.voxelSize(), quantum = h * h * h / 255;
  const TissueTable& tissues = workpiece.tissues();
  std::int64_t taken = 0;
  const std::size_t count = collision.voxels.size(), most = cutter_.mostVoxels;
  const std::size_t stride = (count + most - 1) / most;
  for (std::size_t k = turn_++ % stride; k < count; k += stride) {
    const CollisionVoxel& v = collision.voxels[k];
    const double ability = static_cast<double>(v.ability), hardness = tissues[v.tissue].hardness;
    if (!(ability * cutter_.hardness > hardness)) continue;
    const int left = workpiece.coverage(v.voxel);
    // Nothing is so soft that a step takes more than there is.
    carry_ += std::min(static_cast<double>(stride) * ability * static_cast<double>(v.share) /
                           collision.count * work /
                           (std::max(hardness, 1e-9 * cutter_.hardness) * quantum),
                       static_cast<double>(left));
    const int less = std::min(left, static_cast<int>(carry_));
    if (less < std::min(left, kLeast)) continue;
    carry_ -= less;
    taken += less;
    cuts_.push_back({v.voxel, static_cast<std::uint8_t>(left - less)});
  }
  carry_ = std::min(carry_, 255.0);
  return {workpiece.cut(cuts_), static_cast<double>(taken) * quantum};
}

}  // namespace cloudcontact
