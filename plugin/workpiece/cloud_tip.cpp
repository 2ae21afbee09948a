// With lengths t of the tip below a level over areas, as in kernels/contact/contact_depth.h: sum of
// area t is the volume, sum of area t^2 twice its first moment, sum of area t^3 three times its
// second. A voxel at the surface holds its matter on the side of its full neighbors.
#include "workpiece/cloud_tip.h"

#include <cloudcontact/voxels/cloud.h>

#include <algorithm>
#include <cmath>

#include "kernels/contact/contact_depth.h"
#include "kernels/contact/sample.h"

namespace cloudcontact {

namespace {

// [voxels of the cloud]
constexpr double kAbove = 1;       // from the level to the guess
constexpr double kBelow = 4;       // farthest that the tip ends below the guess
constexpr double kCloseBy = 0.05;  // change of the end that needs no further round
constexpr int kRounds = 4;

// In the cloud's grid [voxels].
struct GridPlace {
  const Cloud& cloud;
  Vec3 at, down;
  double radius;
};

double covered(const Cloud& cloud, const Eigen::Vector3i& v) {
  const bool in = (v.array() >= 0).all() && (v.array() < cloud.size().array()).all();
  return in ? cloud.coverage(v.x(), v.y(), v.z()) / 255.0 : 0;
}

// From a voxel's center to its matter, as a part of the farthest that this may be: a plane that
// cuts the voxel leaves (1 - share) / 2, a density that varies slowly its slope / (12 share).
Vec3 leaning(const Cloud& cloud, const Eigen::Vector3i& v, double share) {
  const double most = 0.5 * (1 - share), gain = std::max(1 / (24 * share), most) / most;
  Vec3 n;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3i step = Eigen::Vector3i::Unit(k);
    n[k] = gain * (covered(cloud, v + step) - covered(cloud, v - step));
  }
  return n.cwiseMax(-1).cwiseMin(1);
}

void add(const GridPlace& place, const Eigen::Vector3i& v, double level, double* moments) {
  const double share = covered(place.cloud, v);
  if (!(share > 0)) return;
  const Vec3 center = v.cast<double>() + Vec3::Constant(0.5) - place.at;
  double depth = center.dot(place.down);
  if ((center - depth * place.down).squaredNorm() > place.radius * place.radius) return;
  double spread = 0.5;
  if (share < 1) {
    const double along = std::clamp(leaning(place.cloud, v, share).dot(place.down), -1.0, 1.0);
    depth += 0.5 * (1 - share) * along;
    spread *= std::sqrt(1 - along * along * (1 - share * share));
  }
  const CcWet wet = ccWet(static_cast<float>(depth - level), static_cast<float>(spread));
  moments[0] += share * static_cast<double>(wet.share);
  moments[1] += 2 * share * static_cast<double>(wet.depth1);
  moments[2] += 3 * share * static_cast<double>(wet.depth2);
}

// The end of the matter below `level`.
double endBelow(const GridPlace& place, double level) {
  const double deep = kAbove + kBelow, middle = level + 0.5 * deep;
  Eigen::Vector3i low, high;
  for (int k = 0; k < 3; ++k) {
    const double d = place.down[k];
    const double reach =
        0.5 * deep * std::abs(d) + place.radius * std::sqrt(std::max(1 - d * d, 0.0)) + 1;
    const double at = place.at[k] + middle * d;
    low[k] = std::max(0, static_cast<int>(std::floor(at - reach)));
    high[k] = std::min(place.cloud.size()[k] - 1, static_cast<int>(std::floor(at + reach)));
  }
  double moments[3] = {0, 0, 0};
  Eigen::Vector3i v;
  for (v.z() = low.z(); v.z() <= high.z(); ++v.z())
    for (v.y() = low.y(); v.y() <= high.y(); ++v.y())
      for (v.x() = low.x(); v.x() <= high.x(); ++v.x()) {
        const double depth = (v.cast<double>() + Vec3::Constant(0.5) - place.at).dot(place.down);
        if (depth > level - 1 && depth < level + deep) add(place, v, level, moments);
      }
  return level + ccDeepestByMoments(moments);
}

}  // namespace

double cloudTip(const PlacedSolid& area, const TipPlace& place, double guess) {
  const Cloud& cloud = *std::get<CloudSolid>(area.solid).cloud;
  const double perVoxel = 1 / cloud.voxelSize();
  const GridPlace grid{cloud, perVoxel * (area.place.toLocal(place.at) - cloud.origin()),
                       area.place.orientation.conjugate() * place.down, perVoxel * place.radius};
  double end = perVoxel * guess;
  for (int k = 0; k < kRounds; ++k) {
    const double before = end;
    end = std::max(end - 0.75 * kAbove, endBelow(grid, end - kAbove));
    if (std::abs(end - before) < kCloseBy) break;
  }
  return end / perVoxel;
}

}  // namespace cloudcontact
