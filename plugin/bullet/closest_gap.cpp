// Samples looked up in the other body, or the distance of surfaces.
#include "bullet/closest_gap.h"

#include <cloudcontact/field/surface_field.h>

#include "bullet/convert.h"
#include "contact/surface_gap.h"

namespace cloudcontact {

namespace {

std::optional<FieldPoint> lookUp(const ContactBody& body, const Vec3& local) {
  if (body.field) return body.field->at(local);
  const SolidPoint point = solidAt(*body.shape, local);
  return FieldPoint{point.depth, point.normal};
}

// The sample of one body nearest to the other's surface; the point's normal leads away from
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

// [voxels] Clouds nearer than this are measured by their samples, others by their surfaces'
// triangles.
constexpr double kNearClouds = 1;

// Two clouds that are not near.
std::optional<ContactPoint> wideGap(const ContactBody& a, const ContactBody& b, double within) {
  const auto gap = surfaceGap(a, b, within);
  if (!gap || !(gap->distance > 0)) return std::nullopt;
  ContactPoint point;
  point.depth = -gap->distance;
  point.normal = (gap->onB - gap->onA) / gap->distance;
  point.position = (gap->onA + gap->onB) / 2;
  return point;
}

}  // namespace

std::optional<ContactPoint> closestGap(const ContactBody& a, const ContactBody& b, double within) {
  const auto ofB = nearestSample(b, a, within);
  auto ofA = nearestSample(a, b, within);
  if (ofA) ofA->normal = -ofA->normal;
  const auto& best = ofA && (!ofB || ofA->depth > ofB->depth) ? ofA : ofB;
  if (!a.field || !b.field) return best;
  const double voxel = std::min(a.field->cloud().voxelSize(), b.field->cloud().voxelSize());
  return best && best->depth > -kNearClouds * voxel ? best : wideGap(a, b, within);
}

// Its addContactPoint() reads the order of the bodies from a manifold.
void reportTo(btManifoldResult& result, const PairSides& sides, const ContactBody& a,
              const ContactBody& b, const ContactResult& contact) {
  btPersistentManifold inOrder(sides.wrapA->getCollisionObject(), sides.wrapB->getCollisionObject(),
                               0, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
  btPersistentManifold* const before = result.getPersistentManifold();
  const auto add = [&result](const ContactPoint& point) {
    const Vec3 onB = point.position - point.depth / 2 * point.normal;
    result.addContactPoint(toBullet(Vec3(-point.normal)), toBullet(onB),
                           static_cast<btScalar>(-point.depth));
  };
  result.setPersistentManifold(&inOrder);
  for (const ContactPoint& point : contact.points) add(point);
  if (contact.points.empty() && result.m_closestPointDistanceThreshold > 0)
    if (const auto gap = closestGap(a, b, result.m_closestPointDistanceThreshold)) add(*gap);
  result.setPersistentManifold(before);
}

}  // namespace cloudcontact
