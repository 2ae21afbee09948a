// Marches along a segment: parts of the grid without a field in one stride, others in strides by
// the field's depth, which is about the distance to the surface. Only the field is asked: where
// there is none, the side is that of the step before.
#include "field/field_ray.h"

#include "base/grid_index.h"
#include "field/closed_form.h"
#include "field/field_data.h"
#include "field/field_layers.h"
#include "field/smoothed_point.h"
#include "law/solid_line.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cloudcontact {

namespace {

constexpr double kStride = 0.5;  // [voxels] thinner than any wall of a cloud
// Of the depth: a stride. A voxel in a corner may hold the plane of the farther wall, by sqrt(3).
constexpr double kSafe = 0.55;
constexpr double kAccuracy = 1e-4;  // [voxels]
constexpr double kNudge = 1e-6;     // [voxels] past a cube's face
constexpr int kBlockEdge = 4;       // [voxels] of FieldRecords::held()
constexpr double kAround = 1;       // [voxels] samples end this far within the surface's bounds
constexpr double kHitMoves = 0.5;   // [voxels] smoothing moves a hit along the ray
constexpr double kSmall = 0.02;     // [voxels] it is not repeated after less
constexpr double kGrazing = 0.05;   // cosine: hits of flatter rays are not smoothed

// A place on the segment.
struct Place {
  double t;      // fraction
  double depth;  // [voxels] its side's width of the band where there is no field
};

// Two places with the surface between them.
struct Crossing {
  Place out, in;
  bool enters;
};

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
        inverse_(step_.cwiseInverse()),
        length_(step_.norm()) {}

  // Calls visit(crossing) for each crossing in order, until it returns false.
  template <typename Visit>
  void visitCrossings(double maxFraction, const Visit& visit) const {
    auto [t, end] = clipped(maxFraction);
    if (!(t <= end)) return;
    // A segment that enters the bounds comes from outside the material.
    bool outside = t > 0 || !(depthAt(t) > 0);
    Place before{t, sideOf(outside)};
    while (t <= end) {
      const Vec3 at = start_ + t * step_;
      const double free = freeUntil(t, at);
      if (free > t) {
        t = free;
        before = {t, sideOf(outside)};
        continue;
      }
      const Place here{t, fieldDepth(at, outside)};
      const bool in = here.depth > 0;
      if (in == outside && !visit(Crossing{in ? before : here, in ? here : before, in})) return;
      outside = !in;
      before = here;
      t = std::min(t + std::max(kStride, kSafe * std::abs(here.depth)) / length_, end);
      if (!(t > here.t)) break;
    }
  }

  FieldHit refined(const Crossing& crossing) const {
    double out = crossing.out.t, in = crossing.in.t;
    while (std::abs(in - out) * length_ > kAccuracy) {
      const double middle = (in + out) / 2;
      if (middle == in || middle == out) break;  // rounding
      (depthAt(middle) > 0 ? in : out) = middle;
    }
    const auto point = field_.at(from_ + in * along_);
    return {in, point ? point->normal : Vec3(-along_.normalized())};
  }

  // The hit on the smoothed surface. It begins where the depth between the two places would be zero
  // if it were linear.
  FieldHit smoothed(const Crossing& crossing) const {
    const auto [out, low] = crossing.out;
    const auto [in, high] = crossing.in;
    FieldHit hit{out + (in - out) * low / (low - high), Vec3::Zero()};
    const double first = hit.fraction;
    double move = 1;
    for (int k = 0; k < 2 && std::abs(move) * length_ > kSmall; ++k) {
      const Vec3 at = from_ + hit.fraction * along_;
      const auto own = field_.at(at);
      if (!own) return refined(crossing);
      const FieldPoint point = smoothedPoint(field_, at, *own);
      hit.normal = point.normal;
      const double rise = point.normal.dot(along_);
      if (std::abs(rise) < kGrazing * along_.norm()) return refined(crossing);
      move = point.depth / rise;
      hit.fraction += move;
      if (std::abs(hit.fraction - first) * length_ > kHitMoves) return refined(crossing);
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

  static double sideOf(bool outside) {
    return outside ? -double(kOutsideLayers) : double(kInsideLayers);
  }
  // Rounds down; cheaper than floor().
  static Eigen::Vector3i voxelAt(const Vec3& at) {
    return (at.array() + kBrickEdge).cast<int>() - kBrickEdge;
  }

  // [voxels] Where the band ends, its width.
  double depthAt(double t) const {
    const Vec3 at = start_ + t * step_;
    const Eigen::Vector3i v = voxelAt(at);
    return fieldDepth(at, cloud_.coverage(v.x(), v.y(), v.z()) < 128);
  }

  // [voxels] Where the band ends, its width on the given side.
  double fieldDepth(const Vec3& at, bool outside) const {
    const Eigen::Vector3i v = voxelAt(at);
    const CcVoxel record = records_.at(v.x(), v.y(), v.z());
    if (ccPlaneCount(record) == 0) return outside ? -double(kOutsideLayers) : double(kInsideLayers);
    const Vec3 from = at - v.cast<double>() - Vec3::Constant(0.5);
    const float x[3] = {float(from.x()), float(from.y()), float(from.z())};
    return ccVoxelDepth(record, data_.planes(), x).depth;
  }

  // Where the segment leaves the cube of bricks, or the block, that holds no field around `at`; `t`
  // itself if there is a field, or the point is outside the grid.
  double freeUntil(double t, const Vec3& at) const {
    const Eigen::Vector3i v = voxelAt(at), bricks = cloud_.bricks();
    const Eigen::Vector3i brick(v.x() >> 3, v.y() >> 3, v.z() >> 3);
    if (!insideGrid(brick, bricks)) return t;
    const std::size_t index = gridIndex(brick, bricks);
    const int distance = records_.brickDistance()[index];
    if (distance > 0)
      return leaves(t, at, kBrickEdge * (brick.array() - (distance - 1)),
                    kBrickEdge * (2 * distance - 1));
    const int block = (v.x() >> 2 & 1) | (v.y() >> 2 & 1) << 1 | (v.z() >> 2 & 1) << 2;
    if (records_.held()[index] >> block & 1) return t;
    return leaves(t, at, kBlockEdge * Eigen::Array3i(v.x() >> 2, v.y() >> 2, v.z() >> 2),
                  kBlockEdge);
  }

  // Where the segment leaves the cube of `edge` voxels whose first voxel is `low`.
  double leaves(double t, const Vec3& at, const Eigen::Array3i& low, int edge) const {
    double exit = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis)
      if (step_[axis] != 0)
        exit =
            std::min(exit, (low[axis] + (step_[axis] > 0 ? edge : 0) - at[axis]) * inverse_[axis]);
    return t + std::max(exit, 0.0) + kNudge / length_;
  }

  const SurfaceField& field_;
  const FieldData& data_;
  const FieldRecords& records_;
  const Cloud& cloud_;
  Eigen::AlignedBox3d bounds_;  // of the surface [m]
  Vec3 from_, along_;           // [m]
  Vec3 start_, step_;           // [voxels], grid's frame
  Vec3 inverse_;                // 1 / step_
  double length_;               // [voxels]
};

}  // namespace

std::optional<FieldHit> firstEntry(const SurfaceField& field, const Vec3& from, const Vec3& to,
                                   double maxFraction) {
  if (!from.allFinite() || !to.allFinite() || from == to) return std::nullopt;
  const Walk walk(field, from, to, 0);
  std::optional<FieldHit> hit;
  walk.visitCrossings(maxFraction, [&](const Crossing& crossing) {
    if (crossing.enters) hit = walk.refined(crossing);
    return !crossing.enters;
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
  if (const RecognizedShape* const form = closedForm(field))
    return visitCrossings(form->placed, from, to, maxFraction, visit);
  const Walk walk(field, from, to, kAround);
  walk.visitCrossings(maxFraction, [&](const Crossing& crossing) {
    return visit(walk.smoothed(crossing), crossing.enters);
  });
}

}  // namespace cloudcontact
