// Borders are walked inside the cloud's box and looked up in its field.
#include "contact/border_hits.h"

#include <algorithm>
#include <cmath>

#include "base/clipped_segment.h"
#include "kernels/contact/search.h"
#include "law/triangle_surface.h"

namespace cloudcontact {

namespace {

class BorderWalk {
 public:
  BorderWalk(const ContactBody& cloud, const ContactBody& shape, const PairFrame& frame, Side side,
             HitColumns& hits)
      : field_(*cloud.field),
        toCloud_(cloud.pose.inverse() * shape.pose),
        toFrame_(frame.pose.inverse() * cloud.pose),
        voxel_(field_.cloud().voxelSize()),
        side_(side),
        hits_(hits) {}
  bool instead = false;
  std::size_t found = 0;

  // The part of the segment in the cloud's box.
  void segment(const Vec3& start, const Vec3& end) {
    const Vec3 from = toCloud_.toWorld(start), way = toCloud_.toWorld(end) - from;
    const auto part = clipToBox(from, way, field_.bounds());
    if (!part || part->first == part->second) return;
    const auto [first, last] = *part;
    const double length = (last - first) * way.norm();
    const int count = std::max(1, static_cast<int>(std::lround(length / voxel_)));
    for (int i = 0; i < count; ++i)
      place(from + (first + (last - first) * (i + 0.5) / count) * way, voxel_ * length / count);
  }

 private:
  void place(const Vec3& x, double area) {
    const auto p = field_.at(x);
    if (!p || p->depth <= 0) return;
    if (instead && found == 0) hits_.clear();
    ++found;
    const Eigen::Vector3f at = toFrame_.toWorld(Vec3(x + p->depth * p->normal)).cast<float>();
    const Eigen::Vector3f own = Vec3(toFrame_.orientation * p->normal).cast<float>(), n = -own;
    const float depth = static_cast<float>(p->depth);
    const CcHit h = ccHitOf(at.data(), own.data(), n.data(), depth, 0);
    hits_.push_back({Eigen::Vector3f(h.position[0], h.position[1], h.position[2]), own, n,
                     static_cast<float>(area), h.wet.share, h.wet.depth1, h.wet.depth2,
                     h.wet.depth3, depth, h.facing, static_cast<std::int8_t>(side_), 0});
  }

  const SurfaceField& field_;
  Pose toCloud_, toFrame_;
  double voxel_;
  Side side_;
  HitColumns& hits_;
};

}  // namespace

std::size_t addBorderHits(const ContactBody& a, const ContactBody& b, const PairFrame& frame,
                          bool instead, HitColumns& hits) {
  const ContactBody& shape = a.shape ? a : b;
  const auto* const solid = shape.shape ? std::get_if<SurfaceSolid>(shape.shape) : nullptr;
  if (!solid || !solid->surface->hasBorders()) return 0;
  BorderWalk walk(a.shape ? b : a, shape, frame, a.shape ? kB : kA, hits);
  walk.instead = instead;
  solid->surface->visitBorders(
      [&walk](const Vec3& start, const Vec3& end) { walk.segment(start, end); });
  return walk.found;
}

}  // namespace cloudcontact
