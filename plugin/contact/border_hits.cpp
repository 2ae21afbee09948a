// Borders are walked inside the cloud's box and looked up in its field.
#include "contact/border_hits.h"

#include <algorithm>
#include <cmath>

#include "base/clipped_segment.h"
#include "contact/near_misses.h"
#include "field/field_layers.h"
#include "kernels/contact/search.h"
#include "law/triangle_surface.h"

namespace cloudcontact {

namespace {

constexpr float kStraight = 0.9f;  // cosine between a sample's normal and the way to a border

class BorderWalk {
 public:
  BorderWalk(const ContactBody& cloud, const ContactBody& shape, const PairFrame& frame, Side side)
      : field_(*cloud.field),
        surface_(*std::get<SurfaceSolid>(*shape.shape).surface),
        toCloud_(cloud.pose.inverse() * shape.pose),
        toFrame_(frame.pose.inverse() * cloud.pose),
        voxel_(field_.cloud().voxelSize()),
        side_(side) {}

  // [m] Farther outside no field knows a place.
  double most() const { return 2 * kOutsideLayers * voxel_; }

  // Calls visit(place, its field point, length [m]) for the places within `margin` of the cloud's
  // box that its field knows.
  template <typename Visit>
  void walk(double margin, const Visit& visit) const {
    Eigen::AlignedBox3d box = field_.bounds();
    box.min().array() -= margin;
    box.max().array() += margin;
    surface_.visitBorders([&](const Vec3& start, const Vec3& end) {
      const Vec3 from = toCloud_.toWorld(start), way = toCloud_.toWorld(end) - from;
      const auto part = clipToBox(from, way, box);
      if (!part || part->first == part->second) return;
      const auto [first, last] = *part;
      const double length = (last - first) * way.norm();
      const int count = std::max(1, static_cast<int>(std::lround(length / voxel_)));
      for (int i = 0; i < count; ++i) {
        const Vec3 x = from + (first + (last - first) * (i + 0.5) / count) * way;
        if (const auto p = field_.at(x)) visit(x, *p, length / count);
      }
    });
  }

  // `shift` [m]: by which the bodies are moved together.
  Hit hitAt(const Vec3& x, const FieldPoint& p, double length, double shift) const {
    const Vec3 surface = x + (p.depth + 0.5 * shift) * p.normal;
    const Eigen::Vector3f at = toFrame_.toWorld(surface).cast<float>();
    const Eigen::Vector3f own = Vec3(toFrame_.orientation * p.normal).cast<float>(), n = -own;
    const float depth = static_cast<float>(p.depth + shift);
    const CcHit h = ccHitOf(at.data(), own.data(), n.data(), depth, 0);
    return hitOf(h, static_cast<float>(voxel_ * length), depth, side_, false);
  }

 private:
  const SurfaceField& field_;
  const TriangleSurface& surface_;
  Pose toCloud_, toFrame_;
  double voxel_;
  Side side_;
};

// Near misses that are moved together by less [m] than before, without those that touch no more or
// see the border aslant.
void moveApart(double by, HitColumns& hits) {
  const std::size_t count = hits.size();
  hits.clear();
  for (std::size_t i = 0; i < count; ++i) {
    Hit hit = hits[i];  // still there
    const float depth = hit.depth - static_cast<float>(by);
    if (depth <= 0 || hit.facing < kStraight) continue;
    setDepth(hit, depth);
    hits.push_back(hit);
  }
}

}  // namespace

double addBorderHits(const ContactBody& a, const ContactBody& b, const PairFrame& frame,
                     double margin, double gap, HitColumns& hits) {
  const ContactBody& shape = a.shape ? a : b;
  const auto* const solid = shape.shape ? std::get_if<SurfaceSolid>(shape.shape) : nullptr;
  if (!solid || !solid->surface->hasBorders()) return gap;
  const BorderWalk walk(a.shape ? b : a, shape, frame, a.shape ? kB : kA);
  const bool apart = gap > 0 || hits.empty();
  const double within = apart ? std::min(std::max(0.0, margin), walk.most()) : 0.0;
  double deepest = -within;
  walk.walk(within, [&](const Vec3&, const FieldPoint& p, double) {
    deepest = std::max(deepest, p.depth);
  });
  if (deepest <= -within) return gap;
  // As HitSearch::touchLightly() moves near misses together.
  const double shift = deepest > 0 ? 0 : NearMissSearch::kLightly * frame.voxel - deepest;
  if (gap > 0 && shift >= gap) return gap;
  if (gap > 0 && shift > 0)
    moveApart(gap - shift, hits);
  else if (apart)
    hits.clear();
  walk.walk(within, [&](const Vec3& x, const FieldPoint& p, double length) {
    if (p.depth + shift > 0) hits.push_back(walk.hitAt(x, p, length, shift));
  });
  return shift;
}

}  // namespace cloudcontact
