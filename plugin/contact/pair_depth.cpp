// The depth of the deepest point: from the samples (kernels/contact/contact_depth.h), and from
// edges.
//
// The samples of a cloud measure the depth to a shape's nearest face: the corner of a box that is
// one voxel in reads 0.58. The corner itself, looked up in the cloud's field, is exact to the
// field's accuracy down to the end of the band at five voxels. So the shape's edges are walked in
// steps of a quarter of a voxel inside a box around the hits. Of two clouds the points where planes
// of a record meet are looked up, near each body's deepest sample (kernels/contact/sharp_point.h).
#include "contact/pair_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "base/clipped_segment.h"
#include "field/field_data.h"
#include "kernels/contact/contact_edges.h"
#include "kernels/contact/sharp_point.h"
#include "law/triangle_surface.h"

namespace cloudcontact {

namespace {

constexpr double kStep = 0.25;   // [voxels]
constexpr int kMostSteps = 512;  // along one edge; long edges take longer steps
// [voxels] Edges rounded by a larger margin are smooth surfaces to a cloud.
constexpr double kSharpMargin = 1;

// The b (kernels/contact/contact_depth.h) from which on a near patch is a tip, and fully so. An
// edge has 1, a tip's samples give 1.8.
constexpr double kTipped = 1.4, kAllTip = 1.8;

class EdgeWalk {
 public:
  EdgeWalk(const Pose& toCloud, const SurfaceField& cloud, const Eigen::AlignedBox3d& within)
      : toCloud_(toCloud), cloud_(cloud), within_(within), voxel_(cloud.cloud().voxelSize()) {}

  double deepest() const { return deepest_; }

  void operator()(const HalfSpace&) {}
  void operator()(const Sphere&) {}
  void operator()(const Capsule&) {}
  void operator()(const Ellipsoid&) {}
  void operator()(const CloudSolid&) {}
  void operator()(const SurfaceSolid& solid) {
    solid.surface->visitEdges(
        [this](const Vec3& start, const Vec3& end) { segment(start, end, 0); });
  }
  void operator()(const Box& box) {
    for (int axis = 0; axis < 3; ++axis)
      for (int k = 0; k < 4; ++k) {
        Vec3 end = box.halfExtents;
        if (k & 1) end[(axis + 1) % 3] *= -1;
        if (k & 2) end[(axis + 2) % 3] *= -1;
        Vec3 start = end;
        start[axis] *= -1;
        segment(start, end, 0);
      }
  }
  void operator()(const Cylinder& cylinder) {
    for (const double z : {-cylinder.halfHeight, cylinder.halfHeight})
      circle(cylinder.radius, z, 0);
  }
  void operator()(const Cone& cone) {
    if (cone.margin > kSharpMargin * voxel_) return;
    circle(cone.radius, -cone.halfHeight, cone.margin);
    point(toCloud_.toWorld({0, 0, cone.halfHeight}), cone.margin);
  }
  void operator()(const Hull& hull) {
    if (hull.margin > kSharpMargin * voxel_) return;
    for (const auto& [a, b] : hull.edges)
      segment(hull.corners[static_cast<std::size_t>(a)], hull.corners[static_cast<std::size_t>(b)],
              hull.margin);
  }

 private:
  void lookUp(const Vec3& x, double margin) {
    if (const auto found = cloud_.at(x)) deepest_ = std::max(deepest_, found->depth + margin);
  }
  void point(const Vec3& x, double margin) {
    if (within_.contains(x)) lookUp(x, margin);
  }

  // Walks the part of the segment inside the box, ends included.
  void segment(const Vec3& start, const Vec3& end, double margin) {
    const Vec3 from = toCloud_.toWorld(start), way = toCloud_.toWorld(end) - from;
    const auto part = clipToBox(from, way, within_);
    if (!part) return;
    const auto [first, last] = *part;
    const int steps = stepsOver((last - first) * way.norm());
    for (int i = 0; i <= steps; ++i)
      lookUp(from + (first + (last - first) * i / steps) * way, margin);
  }

  void circle(double radius, double z, double margin) {
    const auto at = [&](double angle) {
      return toCloud_.toWorld({radius * std::cos(angle), radius * std::sin(angle), z});
    };
    // The step depends on how much of the circle the box can hold, not on the circle's size.
    const double inBox = std::min(2 * std::numbers::pi * radius, 4 * within_.diagonal().norm());
    const double step = inBox / stepsOver(inBox);
    arc(at, 0, 2 * std::numbers::pi, radius, step, margin);
  }

  // Halves an arc that is longer than a step and drops one that is outside the box: no point of an
  // arc is farther from its middle than half its length.
  template <class Place>
  void arc(const Place& at, double first, double last, double radius, double step, double margin) {
    const double length = (last - first) * radius;
    const Vec3 middle = at(0.5 * (first + last));
    if (within_.squaredExteriorDistance(middle) > 0.25 * length * length) return;
    if (length <= step) return point(middle, margin);
    arc(at, first, 0.5 * (first + last), radius, step, margin);
    arc(at, 0.5 * (first + last), last, radius, step, margin);
  }

  int stepsOver(double length) const {
    return std::clamp(static_cast<int>(std::min(length / (kStep * voxel_), 1e6)) + 1, 1,
                      kMostSteps);
  }

  const Pose& toCloud_;
  const SurfaceField& cloud_;
  const Eigen::AlignedBox3d& within_;
  double voxel_;
  double deepest_ = -std::numeric_limits<double>::infinity();
};

// The largest depth [m] of the shape's edges inside `within`, a box in the cloud's frame; negative
// infinity if there are none. `toCloud` maps from the shape's frame.
double deepestEdge(const Solid& shape, const Pose& toCloud, const SurfaceField& cloud,
                   const Eigen::AlignedBox3d& within) {
  EdgeWalk walk(toCloud, cloud, within);
  std::visit(walk, shape);
  return walk.deepest();
}

constexpr double kDeeper = 4;  // see edgeDepth()

// A shape's edges in a cloud, whose samples see too little of them.
double edgeDepth(const DepthQuery& s, double most) {
  const ContactBody &shape = s.a->shape ? *s.a : *s.b, &cloud = s.a->shape ? *s.b : *s.a;
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < s.hits->size(); ++i) box.extend((*s.hits)[i].position.cast<double>());
  // Samples are one, two or four voxels apart, by level. They read less than the shape's depth in
  // the cloud: 0.58 of it at a box's corner, a quarter at a tip of 30 deg. A box that is too large
  // costs time but no accuracy, since all that is deep in the cloud is in contact.
  const double around =
      (1 << s.level) * cloud.field->cloud().voxelSize() + kDeeper * std::max(0.0, most);
  return deepestEdge(*shape.shape, cloud.pose.inverse() * shape.pose, *cloud.field,
                     {Vec3(box.min().array() - around), Vec3(box.max().array() + around)});
}

CcRecords recordsOf(const ContactBody& body) {
  const FieldData& data = body.field->data();
  return {data.records().bricks(), data.records().firsts(), data.records().records(),
          data.planes()};
}

// The depth [m] of the sharp points of one body near the deepest of its hits; 0: none.
double sharpDepth(const ContactBody& own, const ContactBody& other, const DepthQuery& s,
                  Side side) {
  const HitColumns::Columns<const float> c = s.hits->columns();
  std::size_t deepest = s.hits->size();
  for (std::size_t i = 0; i < s.hits->size(); ++i)
    if (s.hits->side(i) == side && (deepest == s.hits->size() || c.depth[i] > c.depth[deepest]))
      deepest = i;
  if (deepest == s.hits->size()) return 0;
  const std::size_t i = deepest;
  const CcWay ways = wayOf(own, other, *s.frame);
  const CcSharpWay way = {recordsOf(own), recordsOf(other), ways.toOther, ways.toFrame,
                          static_cast<float>(own.field->cloud().voxelSize())};
  const float at[3] = {c.x[i], c.y[i], c.z[i]}, normal[3] = {c.ownX[i], c.ownY[i], c.ownZ[i]};
  float sample[3], middle[3], depth = 0;
  ccSampleOfHit(&way, at, normal, c.depth1[i] / c.share[i], sample);
  for (int k = 0; k < ccSharpVoxels(s.level); ++k) {
    ccSharpMiddle(sample, s.level, k, middle);
    depth = ccSharpIn(&way, middle, depth);
  }
  // In a float voxel, as a device has it.
  return static_cast<double>(depth) * static_cast<float>(other.field->cloud().voxelSize());
}

}  // namespace

PairDepth pairDepth(const CcPairSums& patches, const DepthQuery& pair, const CcTerms& terms) {
  CcPairDepth by = ccDepthOfPair(&patches, terms.oneSided, pair.frame->voxel);
  double edged = 0, edge = 0, apart = 0;
  if (patches.size > 0 && !terms.foundation)
    edged = terms.oneSided ? ccEdged(&patches, &by) : ccEdgedOnFace(&patches, &by);
  // Of edges, moments are right.
  double ended = 0;
  if (terms.gap > 0) ended = std::exchange(edged, 0) * ccRamp(by.pointed, kTipped, kAllTip);
  if (edged > 0)
    edge = terms.oneSided ? edgeDepth(pair, patches.most)
                          : std::max(sharpDepth(*pair.a, *pair.b, pair, kA),
                                     sharpDepth(*pair.b, *pair.a, pair, kB));
  const bool gives = edge > (terms.oneSided ? 0 : by.depth);
  if (gives) ccTakeEdge(&by, edged, edge);
  if (gives && terms.oneSided) apart = edged * std::max(0.0, by.depth - edge);
  if (!gives) edged = 0;
  const double error =
      ccDepthError(&patches, &by, edged, pair.level, terms.oneSided, pair.frame->voxel);
  return {by.depth, apart + error, ended};
}

}  // namespace cloudcontact
