// The depth of the deepest point: by the samples (contact_depth.h), and by the edges themselves of
// a plain shape (shape_edges.cpp).
#include "contact/pair_depth.h"

#include "contact/shape_edges.h"

namespace cloudcontact {

namespace {

// An edge counts from the first b on, wholly from the second: on a face and on a cylinder's side
// (0.55) the mean over many samples knows better than one of them.
constexpr double kEdged = 0.6, kAllEdge = 0.8;
constexpr double kDeeper = 4;  // see edgeDepth()

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

double pairDepth(const CcPairSums& patches, const ShapeInCloud* shape, bool oneSided,
                 double voxel) {
  const CcPairDepth by = ccDepthOfPair(&patches, oneSided, voxel);
  const double edged = (1 - by.smooth) * ccRamp(by.pointed, kEdged, kAllEdge);
  if (!shape || !(edged > 0) || !(patches.size > 0)) return by.depth;
  return by.depth + edged * std::max(0.0, edgeDepth(*shape, patches.most) - by.depth);
}

}  // namespace cloudcontact
