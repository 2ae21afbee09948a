// Weighs a body's clouds and compares.
#include "bullet/matter_check.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/voxels/matter_sums.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "bullet/convert.h"
#include "bullet/shape_parts.h"

namespace cloudcontact {

namespace {

// [radii of gyration] From here on the moments about the origin are 1 % larger than those about the
// center, and a body stands a tenth of its size beside where it should.
constexpr double kOffCenter = 0.1;
// Of the smaller of two moments: a torque about one axis turns the body a tenth as much about the
// other, which Bullet's diagonal leaves out.
constexpr double kSkew = 0.1;
// Moments that differ by less count as equal. Voxels are as good; and a body of two densities,
// whose center is kOffCenter away, has moments that differ by the square of that, 0.01.
constexpr double kSameMoments = 0.005;
// A body has less inertia than this share of its uniform matter's only with nearly all its mass in
// the middle: a ball with all of it within a third of its radius has 0.1.
constexpr double kLeastShare = 0.1;

constexpr const char* kOffCenterText =
    "a body's origin is not the center of mass of its cloud, and Bullet turns it about its origin: "
    "make it a CloudBody, or move the cloud there first (Cloud::translated)";
constexpr const char* kSkewText =
    "a body's axes are not the principal axes of its cloud, and Bullet's inertia is diagonal: make "
    "it a CloudBody, or turn it as principalFrame() says";
constexpr const char* kNeverTurns =
    "a body that moves has no inertia, so it does not turn: give it one (calculateLocalInertia()), "
    "or setAngularFactor(0) if it must not turn";
constexpr const char* kImpossible =
    "a body's local inertia is none that its mass could have within its cloud: make it a "
    "CloudBody, or take calculateLocalInertia(mass, inertia), in kg m^2";

// Clouds of a body, at 1 kg/m^3 or their tissues' densities.
struct CloudMatter {
  std::vector<MassProperties> parts;
  Eigen::AlignedBox3d bounds;
  bool known = true;  // no other shapes
  CloudMasses& masses;

  explicit CloudMatter(CloudMasses& given) : masses(given) {}

  void add(const btCollisionShape& shape, const btTransform& place) {
    if (const CloudShape* const cloud = CloudShape::of(shape)) {
      parts.push_back(placed(masses.of(*cloud), toPose(place)));
      const Eigen::AlignedBox3d box = cloud->bounds();
      for (int i = 0; i < 8; ++i)
        bounds.extend(
            toPose(place).toWorld(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i))));
    } else if (shape.getShapeType() != EMPTY_SHAPE_PROXYTYPE) {
      known = false;
    }
  }
};

bool same(const Vec3& a, const Vec3& b, double share) {
  return ((a - b).cwiseAbs().array() <= share * b.array()).all();
}

Vec3 inOrder(Vec3 moments) {
  std::sort(moments.data(), moments.data() + 3);
  return moments;
}

// A body, its moments, and those of its clouds with its mass.
class MatterCheck {
 public:
  MatterCheck(const btRigidBody& body, const CloudMatter& clouds)
      : body_(body), bounds_(clouds.bounds), clouds_(sumOf(clouds.parts)) {
    const double mass = 1 / double(body.getInvMass());
    clouds_.inertia *= mass / clouds_.mass;
    clouds_.mass = mass;
    const Vec3& c = clouds_.centerOfMass;
    aboutOrigin_ =
        clouds_.inertia.diagonal() + mass * (Vec3::Constant(c.squaredNorm()) - c.cwiseProduct(c));
    const Vec3 inverse = toVec3(body.getInvInertiaDiagLocal());
    for (int i = 0; i < 3; ++i) moments_[i] = inverse[i] > 0 ? 1 / inverse[i] : 0;
  }

  std::vector<const char*> faults() const {
    std::vector<const char*> found;
    if (!turns(0) && !turns(1) && !turns(2)) return found;  // its inertia is not used
    if (neverTurns()) return {kNeverTurns};
    if (isImpossible() && !hasPrincipalMoments()) return {kImpossible};
    const bool offCenter = isOffCenter(), skew = isSkew();
    if (!offCenter && !skew) return found;
    const bool stated = !followsFromShape();
    if (offCenter && (!stated || (!isLink() && !bounds_.contains(Vec3::Zero().eval()))))
      found.push_back(kOffCenterText);
    if (skew && !stated) found.push_back(kSkewText);
    return found;
  }

 private:
  bool turns(int axis) const { return body_.getAngularFactor()[axis] != 0; }
  bool neverTurns() const {
    for (int axis = 0; axis < 3; ++axis)
      if (turns(axis) && moments_[axis] == 0) return true;
    return false;
  }
  // More than if all mass were as far from the axis as the bounds go.
  bool isImpossible() const {
    const Vec3 far = bounds_.min().cwiseAbs().cwiseMax(bounds_.max().cwiseAbs());
    const Vec3 square = far.cwiseProduct(far);
    const Vec3 most = clouds_.mass * (Vec3::Constant(square.sum()) - square);
    for (int axis = 0; axis < 3; ++axis)
      if (turns(axis) && ((!isLink() && moments_[axis] > (1 + kSameMoments) * most[axis]) ||
                          moments_[axis] < kLeastShare * clouds_.inertia(axis, axis)))
        return true;
    return false;
  }
  // A link of a machine is mostly larger than the part of it that touches things. Bullet tells a
  // body of those joints alone that keep their bodies from touching each other.
  bool isLink() const { return body_.getNumConstraintRefs() > 0; }
  bool isOffCenter() const {
    const double gyration = std::sqrt(clouds_.inertia.trace() / 2 / clouds_.mass);
    return clouds_.centerOfMass.norm() > kOffCenter * gyration;
  }
  bool isSkew() const {
    const Eigen::Matrix3d& inertia = clouds_.inertia;
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < i; ++k)
        if (std::abs(inertia(i, k)) > kSkew * std::min(inertia(i, i), inertia(k, k))) return true;
    return !same(moments_, inertia.diagonal(), kSameMoments) && hasPrincipalMoments();
  }
  // In any order.
  bool hasPrincipalMoments() const {
    const Vec3 principal = principalAxes(clouds_.inertia).moments;
    return same(inOrder(moments_), inOrder(principal), kSameMoments);
  }
  bool followsFromShape() const {
    btVector3 guess;
    body_.getCollisionShape()->calculateLocalInertia(static_cast<btScalar>(clouds_.mass), guess);
    return same(moments_, toVec3(guess), kSameMoments) || hasPrincipalMoments() ||
           same(moments_, clouds_.inertia.diagonal(), kSameMoments) ||
           same(moments_, aboutOrigin_, kSameMoments);
  }

  const btRigidBody& body_;
  Eigen::AlignedBox3d bounds_;
  MassProperties clouds_;  // in the body's axes, about its own center
  Vec3 aboutOrigin_, moments_;
};

}  // namespace

MassProperties CloudMasses::of(const CloudShape& shape) {
  std::vector<double> densities;
  for (const Tissue& tissue : shape.tissues()) densities.push_back(tissue.density);
  if (densities.empty()) densities = {1};
  const std::weak_ptr<const void> life = shape.cloud().life();
  const auto same = [&life](const Known& known) {
    return !known.life.owner_before(life) && !life.owner_before(known.life);
  };
  for (const Known& known : known_)
    if (same(known) && known.densities == densities) return known.mass;
  std::erase_if(known_, [](const Known& known) { return known.life.expired(); });
  known_.push_back({life, densities, massPropertiesOf(shape.cloud(), densities)});
  return known_.back().mass;
}

std::vector<const char*> wrongMatter(const btCollisionObject& object, CloudMasses& masses) {
  const btRigidBody* const body = btRigidBody::upcast(&object);
  if (!body || body->isStaticOrKinematicObject() || !(body->getInvMass() > 0)) return {};
  CloudMatter clouds(masses);
  forEachPart(*body->getCollisionShape(), btTransform::getIdentity(),
              [&](const btCollisionShape& part, const btTransform& place, int) {
                clouds.add(part, place);
              });
  if (!clouds.known || clouds.parts.empty()) return {};
  return MatterCheck(*body, clouds).faults();
}

}  // namespace cloudcontact
