// Friction rows along their load, and how far their springs are stretched.
#include "bullet/point_friction.h"

#include <algorithm>
#include <cmath>

#include "bullet/convert.h"

namespace cloudcontact {

namespace {

// Fraction of the Coulomb limit above which rows turn to their load. Below it no row is near its
// bound, so directions do not matter and stay as they are.
constexpr double kNearLimit = 0.5;

// Fraction of the Coulomb limit above which a patch slides.
constexpr double kSliding = 0.99;

}  // namespace

Vec3 slipOf(const ContactPoint& point, const Motion& a, const Motion& b) {
  const Vec3 slip = a.at(point.position) - b.at(point.position);
  return slip - slip.dot(point.normal) * point.normal;
}

void RigidVectors::add(const Vec3& position, const Vec3& vector) {
  at_[count_] = position;
  vectors_[count_++] = vector;
}

void RigidVectors::fit() {
  for (int i = 0; i < count_; ++i) {
    center_ += at_[i] / count_;
    mean_ += vectors_[i] / count_;
  }
  double polar = 0;
  for (int i = 0; i < count_; ++i) {
    spin_ += (at_[i] - center_).cross(vectors_[i]);
    polar += (at_[i] - center_).squaredNorm();
  }
  if (polar > 0) spin_ /= polar;
}

void PatchLoad::add(const Vec3& position, const btManifoldPoint* before) {
  Vec3 held = Vec3::Zero();
  if (before) {
    held = toVec3(before->m_lateralFrictionDir1) * before->m_appliedImpulseLateral1 +
           toVec3(before->m_lateralFrictionDir2) * before->m_appliedImpulseLateral2;
    limit_ += before->m_combinedFriction * before->m_appliedImpulse;
  }
  held_.add(position, held);
  ++count_;
}

void PatchLoad::sum(double mass) {
  mass_ = mass;
  limit_ /= count_;
  held_.fit();
}

Vec3 PatchLoad::at(const Vec3& position, const Vec3& slip) const {
  const Vec3 load = mass_ * slip - held_.at(position);
  return load.norm() > kNearLimit * limit_ ? load : Vec3::Zero();
}

void setFrictionDirections(const Vec3& position, const Vec3& slip, const PatchLoad& load,
                           const btManifoldPoint* before, btManifoldPoint& point) {
  Vec3 wanted = load.at(position, slip);
  if (wanted.isZero(0) && before) wanted = toVec3(before->m_lateralFrictionDir1);
  const btVector3& normal = point.m_normalWorldOnB;
  const Vec3 n = toVec3(normal), along = wanted - n.dot(wanted) * n;
  // The rest of a vector along the normal is rounding, not a direction.
  if (along.norm() <= 1e-3 * wanted.norm()) {
    btPlaneSpace1(normal, point.m_lateralFrictionDir1, point.m_lateralFrictionDir2);
    return;
  }
  point.m_lateralFrictionDir1 = toBullet(Vec3(along.normalized()));
  point.m_lateralFrictionDir2 = point.m_lateralFrictionDir1.cross(normal);
}

FrictionSpring FrictionSpring::of(const btManifoldPoint& point, double mass, double step) {
  if (!(point.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING)) return {};
  const double stiffness = point.m_combinedContactStiffness1;
  const double damping = std::max(0.0, double(point.m_combinedContactDamping1));
  if (!(stiffness > 0) || !(step > 0)) return {};
  const double grip = step * stiffness + damping;
  return {kTangent * std::max(step * grip, mass), stiffness / grip};
}

Vec3 FrictionSpring::stretched(const btManifoldPoint& point, const Vec3& slip, double step) const {
  Vec3 stretch = Vec3::Zero();
  if (!(weight > 0)) return stretch;
  const double limit = point.m_combinedFriction * point.m_appliedImpulse;
  const auto add = [&](const btVector3& direction, double target, double impulse) {
    const Vec3 along = toVec3(direction);
    const bool holds = std::abs(impulse) < kSliding * limit;
    const double rate = holds ? slip.dot(along) : target - impulse / weight;
    stretch += (step * rate - target / back) * along;
  };
  add(point.m_lateralFrictionDir1, point.m_contactMotion1, point.m_appliedImpulseLateral1);
  add(point.m_lateralFrictionDir2, point.m_contactMotion2, point.m_appliedImpulseLateral2);
  return stretch;
}

void FrictionSpring::write(const Vec3& stretch, double mass, btManifoldPoint& point) const {
  if (!(weight > 0)) return;
  const Vec3 target = -back * stretch;
  point.m_contactMotion1 = static_cast<btScalar>(target.dot(toVec3(point.m_lateralFrictionDir1)));
  point.m_contactMotion2 = static_cast<btScalar>(target.dot(toVec3(point.m_lateralFrictionDir2)));
  point.m_frictionCFM = static_cast<btScalar>(mass / weight);
}

}  // namespace cloudcontact
