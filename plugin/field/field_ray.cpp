// Marches along a segment: empty and solid bricks in one stride, bricks with a surface in strides
// of half a voxel. The crossing is found by bisection of the field's depth.
#include "field/field_ray.h"

#include "base/grid_index.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

constexpr double kStride = 0.5;     // [voxels] thinner than any wall of a cloud
constexpr double kAccuracy = 1e-4;  // [voxels]
constexpr double kNudge = 1e-6;     // [voxels] past a brick's face

class Walk {
 public:
  Walk(const SurfaceField& field, const Vec3& from, const Vec3& to)
      : field_(field),
        cloud_(field.cloud()),
        from_(from),
        along_(to - from),
        start_((from - cloud_.origin()) / cloud_.voxelSize()),
        step_(along_ / cloud_.voxelSize()),
        length_(step_.norm()) {}

  std::optional<FieldHit> firstEntry(double maxFraction) const {
    auto [t, end] = clipped(maxFraction);
    if (!(t <= end)) return std::nullopt;
    // A segment that enters the bounds comes from outside the material.
    bool outside = t > 0 || !inside(t);
    double before = t;
    while (t <= end) {
      const bool in = inside(t);
      if (in && outside) return refined(before, t);
      outside = !in;
      before = t;
      t = std::min(next(t), end);
      if (before >= end) break;
    }
    return std::nullopt;
  }

 private:
  // The part of [0, maxFraction] inside the surface's bounds.
  std::pair<double, double> clipped(double maxFraction) const {
    const Eigen::AlignedBox3d box = field_.bounds();
    double enter = 0, leave = maxFraction;
    for (int axis = 0; axis < 3; ++axis) {
      if (along_[axis] == 0) {
        if (from_[axis] < box.min()[axis] || from_[axis] > box.max()[axis]) return {1, 0};
        continue;
      }
      const double a = (box.min()[axis] - from_[axis]) / along_[axis];
      const double b = (box.max()[axis] - from_[axis]) / along_[axis];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return {enter, leave};
  }

  bool inside(double t) const {
    if (const auto point = field_.at(from_ + t * along_)) return point->depth > 0;
    const Eigen::Vector3i voxel = (start_ + t * step_).array().floor().cast<int>();
    return cloud_.coverage(voxel.x(), voxel.y(), voxel.z()) >= 128;
  }

  // The next point to test: past the brick if it has no surface, else a short stride farther.
  double next(double t) const {
    const Vec3 at = start_ + t * step_;
    const Eigen::Vector3i brick = (at / kBrickEdge).array().floor().cast<int>();
    const Eigen::Vector3i bricks = cloud_.bricks();
    if (!insideGrid(brick, bricks)) return t + kStride / length_;
    if (cloud_.voxels().table[gridIndex(brick, bricks)] >= 0) return t + kStride / length_;
    double exit = kBrickEdge * 2;  // [voxels] more than a brick's diagonal
    for (int axis = 0; axis < 3; ++axis) {
      if (step_[axis] == 0) continue;
      const double face = kBrickEdge * (brick[axis] + (step_[axis] > 0 ? 1 : 0));
      exit = std::min(exit, (face - at[axis]) / step_[axis] * length_);
    }
    return t + (std::max(exit, 0.0) + kNudge) / length_;
  }

  FieldHit refined(double out, double in) const {
    while ((in - out) * length_ > kAccuracy) {
      const double middle = (in + out) / 2;
      (inside(middle) ? in : out) = middle;
    }
    const auto point = field_.at(from_ + in * along_);
    return {in, point ? point->normal : Vec3(-along_.normalized())};
  }

  const SurfaceField& field_;
  const Cloud& cloud_;
  Vec3 from_, along_;  // [m]
  Vec3 start_, step_;  // [voxels], grid's frame
  double length_;      // [voxels]
};

}  // namespace

std::optional<FieldHit> firstEntry(const SurfaceField& field, const Vec3& from, const Vec3& to,
                                   double maxFraction) {
  if (!from.allFinite() || !to.allFinite() || from == to) return std::nullopt;
  return Walk(field, from, to).firstEntry(maxFraction);
}

}  // namespace cloudcontact
