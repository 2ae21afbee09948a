// Friction rows along their load, and the memory of standing points.
#include "bullet/point_friction.h"

#include "bullet/convert.h"

namespace cloudcontact {

namespace {

// Fraction of the Coulomb limit above which rows turn to their load. Below it no row is near its
// bound, so directions do not matter and stay as they are.
constexpr double kNearLimit = 0.5;

// Fraction of the Coulomb limit above which a patch slides.
constexpr double kSliding = 0.99;

// Fraction of a standing point's slip that friction takes back each step, and the most slip that it
// keeps, in steps at the sliding speed.
constexpr double kAnchor = 0.2;
constexpr double kAnchorSteps = 10;

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

bool PatchLoad::slides() const {
  return held_.mean().norm() > kSliding * limit_;
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

void PatchAnchor::add(const Vec3& position, const Vec3& slip, const btManifoldPoint* before) {
  if (!before || slip.norm() > slidingSpeed_) return;
  Vec3 back = -(toVec3(before->m_lateralFrictionDir1) * before->m_contactMotion1 +
                toVec3(before->m_lateralFrictionDir2) * before->m_contactMotion2) +
              kAnchor * slip;
  const double most = kAnchor * kAnchorSteps * slidingSpeed_;
  if (back.norm() > most) back *= most / back.norm();
  back_.add(position, back);
}

void PatchAnchor::set(const Vec3& position, btManifoldPoint& point) const {
  const Vec3 back = back_.at(position);
  point.m_contactMotion1 = static_cast<btScalar>(-back.dot(toVec3(point.m_lateralFrictionDir1)));
  point.m_contactMotion2 = static_cast<btScalar>(-back.dot(toVec3(point.m_lateralFrictionDir2)));
}

}  // namespace cloudcontact
