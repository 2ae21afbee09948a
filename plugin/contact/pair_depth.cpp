// The depth of the deepest point, told from all samples.
//
// By moments: depth_moments.h.
//
// By curvature. The moments are those of the rim, too, and few samples make a poor rim: two spheres
// of 16 voxels pressed 0.3 read up to 7 % too deep. Where both surfaces are smooth, depth falls
// from the deepest point as t(x) = d - x K x / 2, so that at every sample, wet or hardly so, t + x
// K x / 2 = d; K is how the normals turn over the patch (1.1 %). Such a patch is told by its b,
// which then follows from the mean of x K x / 2.
//
// By the edges themselves, of a plain shape: see shape_edges.cpp.
#include "pair_depth.h"

#include "depth_moments.h"
#include "shape_edges.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

// Surfaces are smooth where b and what curvature makes of it differ by less than b's noise, one
// over the root of the number of hits, and not where by more than this many times that. Nor where
// their normals lean far apart, as at a corner, whose b may agree by chance: a ball of 10 voxels
// pressed in by one leans by 0.97.
constexpr double kSharp = 1.6, kLeans = 0.93, kLeansFar = 0.87;
// And they are curved where b is more than noise: on a face it is 0.02.
constexpr double kFlat = 0.1, kCurved = 0.3;
// An edge counts from the first b on, wholly from the second: on a face and on a cylinder's side
// (0.55) the mean over many samples knows better than one of them.
constexpr double kEdged = 0.6, kAllEdge = 0.8;
constexpr double kDeeper = 4;  // see edgeDepth()

// 0 up to `none`, 1 from `all` on.
double ramp(double x, double none, double all) {
  return std::clamp((x - none) / (all - none), 0.0, 1.0);
}

// Sums over all patches.
struct PairSums {
  double moments[2][3] = {};  // each body's
  int hits = 0;
  double area = 0, volume = 0;              // [m^2, m^3]
  double square = 0, middle = 0, fall = 0;  // times the volume [m^4]
  double lean = 0, trust = 0, size = 0;     // [m^3]
  double most = -1e300;                     // at a sample itself [m]

  void add(const FoundPatch& p, bool oneSided) {
    const Sums& s = *p.sums;
    for (int side = 0; side < 2; ++side)
      for (int k = 0; k < 3; ++k) moments[side][k] += s.side[side].depth[k];
    hits += s.hits;
    area += s.area;
    volume += s.facing;
    square += (oneSided ? 0.5 : 1.0) * (s.side[0].depth[1] + s.side[1].depth[1]);
    middle += s.middle;
    fall += s.facing * p.force.fall;
    lean += s.facing * p.force.lean;
    trust += p.size * p.force.trustA;
    size += p.size;
    most = std::max(most, s.deepest);
  }

  // The more coherent body's surface is where depth is measured: by the other body's samples.
  double byMoments(bool oneSided) const {
    const double byA = deepestByMoments(moments[kA]), byB = deepestByMoments(moments[kB]);
    if (oneSided || byA == 0 || byB == 0) return std::max(byA, byB);
    return (trust * byB + (size - trust) * byA) / size;
  }

  double pointedness(double depth) const { return volume > 0 ? depth * area / volume - 1 : 0; }

  // How far curvature tells the depth, 0..1.
  double smooth(double depth) const {
    if (!(square > 0)) return 0;
    const double bulge = 2 * fall / square;
    const double off = std::abs(pointedness(depth) - bulge) * std::sqrt(static_cast<double>(hits));
    return ramp(off, kSharp, 1) * ramp(lean / volume, kLeansFar, kLeans) *
           ramp(bulge, kFlat, kCurved);
  }
};

double edgeDepth(const ShapeInCloud& s, double most) {
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < s.hits->size(); ++i) box.extend((*s.hits)[i].position.cast<double>());
  // Samples of the level stand a voxel, two, or four apart; and they are less deep in the shape
  // than it is in the cloud, for they measure to its nearest face: 0.58 of that at a box's corner,
  // a quarter at a tip of 30 deg. A box that is too large costs time and no accuracy: all that lies
  // deep in the cloud is in contact.
  const double around =
      (1 << s.level) * s.cloud->field->cloud().voxelSize() + kDeeper * std::max(0.0, most);
  return deepestEdge(*s.shape->shape, s.cloud->pose.inverse() * s.shape->pose, *s.cloud->field,
                     {Vec3(box.min().array() - around), Vec3(box.max().array() + around)});
}

}  // namespace

double pairDepth(const std::vector<FoundPatch>& patches, const ShapeInCloud* shape, bool oneSided,
                 double voxel) {
  PairSums sums;
  for (const FoundPatch& p : patches) sums.add(p, oneSided);
  if (!(sums.size > 0)) return 0;
  const double rough = sums.byMoments(oneSided), smooth = sums.smooth(rough);
  double depth = rough;
  if (smooth > 0) depth += smooth * ((sums.middle + sums.fall) / sums.volume - rough);
  // A rim of samples that hardly touch must not look like a face that is pressed in.
  depth = std::max(0.0, std::min(depth, sums.most + kRim * voxel));
  const double edged = (1 - smooth) * ramp(sums.pointedness(rough), kEdged, kAllEdge);
  if (shape && edged > 0) depth += edged * std::max(0.0, edgeDepth(*shape, sums.most) - depth);
  return depth;
}

}  // namespace cloudcontact
