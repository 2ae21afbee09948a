// Samples of each cloud, looked up one by one in the other body.
#include "bullet/closest_gap.h"

namespace cloudcontact {

namespace {

std::optional<FieldPoint> lookUp(const ContactBody& body, const Vec3& local) {
  if (body.field) return body.field->at(local);
  const SolidPoint point = solidAt(*body.shape, local);
  return FieldPoint{point.depth, point.normal};
}

// The nearest sample of one body over the other's surface; the point's normal leads away from
// `other`.
std::optional<ContactPoint> nearestSample(const ContactBody& sampled, const ContactBody& other,
                                          double within) {
  std::optional<ContactPoint> best;
  if (!sampled.field) return best;
  const Cloud& cloud = sampled.field->cloud();
  const Pose toOther = other.pose.inverse() * sampled.pose;
  for (std::size_t k = 0; k < sampled.field->sampleCount(); ++k) {
    const SurfaceSample sample = sampled.field->sample(k);
    const Vec3 grid = Eigen::Map<const Eigen::Vector3f>(sample.position).cast<double>();
    const Vec3 local = toOther.toWorld(cloud.origin() + cloud.voxelSize() * grid);
    const auto found = lookUp(other, local);
    if (!found || -found->depth > within) continue;
    if (best && found->depth <= best->depth) continue;
    best.emplace();
    best->depth = found->depth;
    best->normal = other.pose.orientation * found->normal;
    best->position = other.pose.toWorld(local + found->depth / 2 * found->normal);
  }
  return best;
}

}  // namespace

std::optional<ContactPoint> closestGap(const ContactBody& a, const ContactBody& b, double within) {
  const auto ofB = nearestSample(b, a, within);
  auto ofA = nearestSample(a, b, within);
  if (ofA) ofA->normal = -ofA->normal;
  if (!ofA || !ofB) return ofA ? ofA : ofB;
  return ofA->depth > ofB->depth ? ofA : ofB;
}

}  // namespace cloudcontact
