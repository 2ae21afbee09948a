// Marches along a segment: bricks without surface in one stride, others in strides by the field's
// depth, which is about the distance to the surface.
#include "field/field_ray.h"

#include "base/grid_index.h"
#include "field/closed_form.h"
#include "field/field_data.h"
#include "field/field_layers.h"
#include "field/smoothed_point.h"
#include "law/solid_line.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

constexpr double kStride = 0.5;  // [voxels] thinner than any wall of a cloud
// Of the depth: a stride. A voxel in a corner may hold the plane of the farther wall, by sqrt(3).
constexpr double kSafe = 0.55;
constexpr double kAccuracy = 1e-4;  // [voxels]
constexpr double kNudge = 1e-6;     // [voxels] past a brick's face
constexpr double kAround = 1;       // [voxels] samples end this far within the surface's bounds
constexpr double kFarthest = 0.5;   // [voxels] smoothing moves a hit along the ray
constexpr double kSmall = 0.02;     // [voxels] it is not repeated after less
constexpr double kGrazing = 0.05;   // cosine: hits of flatter rays are not smoothed

class Walk {
 public:
  Walk(const SurfaceField& field, const Vec3& from, const Vec3& to, double around)
      : field_(field),
        data_(field.data()),
        records_(data_.records()),
        cloud_(field.cloud()),
        bounds_(boundsOf(field, around)),
        from_(from),
        along_(to - from),
        start_((from - cloud_.origin()) / cloud_.voxelSize()),
        step_(along_ / cloud_.voxelSize()),
        length_(step_.norm()) {}

  // Calls visit(before, after, enters) for the fractions on both sides of a crossing, until it
  // returns false.
  template <typename Visit>
  void visitCrossings(double maxFraction, const Visit& visit) const {
    auto [t, end] = clipped(maxFraction);
    if (!(t <= end)) return;
    // A segment that enters the bounds comes from outside the material.
    bool outside = t > 0 || !(depthAt(t) > 0);
    double before = t;
    while (t <= end) {
      const double depth = depthAt(t);
      const bool in = depth > 0;
      if (in == outside && !visit(before, t, in)) return;
      outside = !in;
      before = t;
      t = std::min(next(t, depth), end);
      if (before >= end || !(t > before)) break;
    }
  }

  FieldHit refined(double out, double in) const {
    while (std::abs(in - out) * length_ > kAccuracy) {
      const double middle = (in + out) / 2;
      if (middle == in || middle == out) break;  // rounding
      (depthAt(middle) > 0 ? in : out) = middle;
    }
    const auto point = field_.at(from_ + in * along_);
    return {in, point ? point->normal : Vec3(-along_.normalized())};
  }

  // The hit on the smoothed surface, between a place outside and one inside. It begins where the
  // depth between them would be zero if it were linear.
  FieldHit smoothed(double out, double in) const {
    while (std::abs(in - out) * length_ > 2 * kStride) {  // a brick was passed
      const double middle = (in + out) / 2;
      if (middle == in || middle == out) break;  // rounding
      (depthAt(middle) > 0 ? in : out) = middle;
    }
    const double high = depthAt(in), low = depthAt(out);
    FieldHit hit{out + (in - out) * low / (low - high), Vec3::Zero()};
    const double first = hit.fraction;
    double move = 1;
    for (int k = 0; k < 2 && std::abs(move) * length_ > kSmall; ++k) {
      const Vec3 at = from_ + hit.fraction * along_;
      const auto own = field_.at(at);
      if (!own) return refined(out, in);
      const FieldPoint point = smoothedPoint(field_, at, *own);
      hit.normal = point.normal;
      const double rise = point.normal.dot(along_);
      if (std::abs(rise) < kGrazing * along_.norm()) return refined(out, in);
      move = point.depth / rise;
      hit.fraction += move;
      if (std::abs(hit.fraction - first) * length_ > kFarthest) return refined(out, in);
    }
    hit.fraction = std::max(hit.fraction, 0.0);
    return hit;
  }

 private:
  static Eigen::AlignedBox3d boundsOf(const SurfaceField& field, double around) {
    const Vec3 more = Vec3::Constant(around * field.cloud().voxelSize());
    const Eigen::AlignedBox3d box = field.bounds();
    return {box.min() - more, box.max() + more};
  }

  // The part of [0, maxFraction] inside the surface's bounds.
  std::pair<double, double> clipped(double maxFraction) const {
    const Eigen::AlignedBox3d& box = bounds_;
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

  // [voxels] Where the band ends, its width.
  double depthAt(double t) const {
    const Vec3 at = start_ + t * step_;
    const Eigen::Vector3i v = at.array().floor().cast<int>();
    const CcVoxel record = records_.at(v.x(), v.y(), v.z());
    if (ccPlaneCount(record) == 0)
      return cloud_.coverage(v.x(), v.y(), v.z()) >= 128 ? double(kInsideLayers)
                                                         : -double(kOutsideLayers);
    const Vec3 from = at - v.cast<double>() - Vec3::Constant(0.5);
    const float x[3] = {float(from.x()), float(from.y()), float(from.z())};
    return ccVoxelDepth(record, data_.planes(), x).depth;
  }

  // The next point to test: past the brick if it has no surface.
  double next(double t, double depth) const {
    const Vec3 at = start_ + t * step_;
    const Eigen::Vector3i brick = (at / kBrickEdge).array().floor().cast<int>();
    const Eigen::Vector3i bricks = cloud_.bricks();
    const double stride = t + std::max(kStride, kSafe * std::abs(depth)) / length_;
    if (!insideGrid(brick, bricks)) return stride;
    if (cloud_.voxels().table[gridIndex(brick, bricks)] >= 0) return stride;
    double exit = kBrickEdge * 2;  // [voxels] more than a brick's diagonal
    for (int axis = 0; axis < 3; ++axis) {
      if (step_[axis] == 0) continue;
      const double face = kBrickEdge * (brick[axis] + (step_[axis] > 0 ? 1 : 0));
      exit = std::min(exit, (face - at[axis]) / step_[axis] * length_);
    }
    return std::max(stride, t + (std::max(exit, 0.0) + kNudge) / length_);
  }

  const SurfaceField& field_;
  const FieldData& data_;
  const FieldRecords& records_;
  const Cloud& cloud_;
  Eigen::AlignedBox3d bounds_;  // of the surface [m]
  Vec3 from_, along_;           // [m]
  Vec3 start_, step_;           // [voxels], grid's frame
  double length_;               // [voxels]
};

}  // namespace

std::optional<FieldHit> firstEntry(const SurfaceField& field, const Vec3& from, const Vec3& to,
                                   double maxFraction) {
  if (!from.allFinite() || !to.allFinite() || from == to) return std::nullopt;
  const Walk walk(field, from, to, 0);
  std::optional<FieldHit> hit;
  walk.visitCrossings(maxFraction, [&](double before, double after, bool enters) {
    if (enters) hit = walk.refined(before, after);
    return !enters;
  });
  return hit;
}

namespace {

void visitCrossings(const PlacedSolid& form, const Vec3& from, const Vec3& to, double maxFraction,
                    const std::function<bool(const FieldHit&, bool enters)>& visit) {
  const Vec3 along = to - from;
  const double length = along.norm();
  const auto span = SolidLines(form, along / length, length).through(from);
  if (!span) return;
  // Calls visit() for one end of the span. Returns whether to go on.
  const auto pass = [&](double at, bool enters) {
    const double fraction = at / length;
    if (!(fraction >= 0 && fraction <= maxFraction)) return true;
    return visit({fraction, normalOf(form, from + fraction * along)}, enters);
  };
  if (pass(span->from, true)) pass(span->to, false);
}

}  // namespace

void visitCrossings(const SurfaceField& field, const Vec3& from, const Vec3& to, double maxFraction,
                    const std::function<bool(const FieldHit&, bool enters)>& visit) {
  if (!from.allFinite() || !to.allFinite() || from == to) return;
  if (const PlacedSolid* const form = closedForm(field))
    return visitCrossings(*form, from, to, maxFraction, visit);
  const Walk walk(field, from, to, kAround);
  walk.visitCrossings(maxFraction, [&](double before, double after, bool enters) {
    return visit(enters ? walk.smoothed(before, after) : walk.smoothed(after, before), enters);
  });
}

}  // namespace cloudcontact
