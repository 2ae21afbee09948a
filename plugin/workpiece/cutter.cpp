// Archard's volume, distributed in whole 255ths of a voxel. The loss of the voxels is summed along
// their list, and each voxel loses the whole part of the sum: nothing is lost to rounding.
#include <cloudcontact/workpiece/cutter.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace cloudcontact {

// Least loss of a voxel at once, unless less is left [1/255]: each change updates the 81 voxels of
// a window, so fewer and larger changes are cheaper.
constexpr int kLeast = 8;

CuttingProcess::CuttingProcess(const Cutter& cutter) : cutter_(cutter) {
  for (const double value : {cutter.hardness, cutter.efficiency, cutter.edgeSpeed})
    if (!(value >= 0) || !std::isfinite(value))
      throw std::invalid_argument(
          "Cutter: hardness, efficiency and edge speed must be zero or more and finite");
  if (cutter.mostVoxels < 1) throw std::invalid_argument("Cutter: mostVoxels must be positive");
}

// What is left of a voxel inside the tool [1/255]: `share` is the part of the voxel inside, times
// its coverage. Otherwise a groove grows wider than its tool.
static int leftInside(const CollisionVoxel& v, int coverage) {
  if (coverage == 0) return 0;
  const double outside = 255 - 255.0 * 255.0 * static_cast<double>(v.share) / coverage;
  const int left =
      coverage - static_cast<int>(std::clamp(std::ceil(outside), 0.0, double(coverage)));
  return left < std::min(coverage, kLeast) ? 0 : left;  // a trace, not worth a change
}

CuttingProcess::Cut CuttingProcess::step(BaseVectorField& workpiece, const Collision& collision,
                                         double force, double speed, double seconds) {
  cuts_.clear();
  const double work = cutter_.efficiency * force * (cutter_.edgeSpeed + speed) * seconds;
  if (!(work > 0) || !std::isfinite(work) || collision.empty()) return {};
  const double h = workpiece.voxelSize(), quantum = h * h * h / 255;
  const TissueTable& tissues = workpiece.tissues();
  std::int64_t removed = 0;
  const std::size_t count = collision.voxels.size(), most = cutter_.mostVoxels;
  const std::size_t stride = (count + most - 1) / most;
  const auto leftOf = [&](const CollisionVoxel& v, int coverage) {
    return cutter_.keepsOutside ? leftInside(v, coverage) : coverage;
  };
  // Voxels with nothing left to cut bear no load: the others take their part.
  double bearing = cutter_.keepsOutside ? 0 : collision.count;
  if (cutter_.keepsOutside)
    for (const CollisionVoxel& v : collision.voxels)
      if (leftOf(v, workpiece.coverage(v.voxel)) > 0) bearing += static_cast<double>(v.share);
  for (std::size_t k = turn_++ % stride; k < count; k += stride) {
    const CollisionVoxel& v = collision.voxels[k];
    const double ability = static_cast<double>(v.ability), hardness = tissues[v.tissue].hardness;
    if (!(ability * cutter_.hardness > hardness)) continue;
    const int coverage = workpiece.coverage(v.voxel);
    const int left = leftOf(v, coverage);
    if (left == 0 && cutter_.keepsOutside) continue;
    // At most all that is left, however soft.
    carry_ += std::min(static_cast<double>(stride) * ability * static_cast<double>(v.share) /
                           bearing * work / (std::max(hardness, 1e-9 * cutter_.hardness) * quantum),
                       static_cast<double>(left));
    const int less = std::min(left, static_cast<int>(carry_));
    if (less < std::min(left, kLeast)) continue;
    carry_ -= less;
    removed += less;
    cuts_.push_back({v.voxel, static_cast<std::uint8_t>(coverage - less)});
  }
  carry_ = std::min(carry_, 255.0);
  return {workpiece.cut(cuts_), static_cast<double>(removed) * quantum};
}

}  // namespace cloudcontact
