// Contact points to btManifoldPoint. Bullet's normal points from body 1 (our B) to body 0 (our A),
// the reverse of ours. A point's id is kept in m_partId0 and its patch in m_partId1: both are free,
// as a cloud's pairs have no triangles, and users may read them there.
#include "manifold_writer.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>

#include <algorithm>

#include "convert.h"

namespace cloudcontact {

namespace {

// The share of the Coulomb limit from which a point's friction is turned to face the force. Below
// it no row is near its bound, so the directions do not matter and had better not move.
constexpr double kNearLimit = 0.5;

// What a pair's points have in common: Bullet's combined coefficients, and its flags.
btManifoldPoint commonOf(const PairSides& sides, LawForm law) {
  const btCollisionObject* const a = sides.wrapA->getCollisionObject();
  const btCollisionObject* const b = sides.wrapB->getCollisionObject();
  btManifoldPoint point;
  point.m_combinedFriction = gCalculateCombinedFrictionCallback(a, b);
  point.m_combinedRollingFriction = gCalculateCombinedRollingFrictionCallback(a, b);
  point.m_combinedSpinningFriction = gCalculateCombinedSpinningFrictionCallback(a, b);
  // A restitution on top of a spring would bounce twice.
  point.m_combinedRestitution =
      law == LawForm::Rigid ? gCalculateCombinedRestitutionCallback(a, b) : btScalar(0);
  point.m_index0 = sides.wrapA->m_index;  // a compound's child
  point.m_index1 = sides.wrapB->m_index;
  point.m_contactPointFlags = 0;
  if (law != LawForm::Rigid) point.m_contactPointFlags |= BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING;
  // Anisotropic friction is left to Bullet, which bends the directions it chooses itself.
  if (!a->hasAnisotropicFriction() && !b->hasAnisotropicFriction())
    point.m_contactPointFlags |= BT_CONTACT_FLAG_LATERAL_FRICTION_INITIALIZED;
  return point;
}

void copyLearnt(const btManifoldPoint& from, btManifoldPoint& to) {
  to.m_appliedImpulse = from.m_appliedImpulse;
  to.m_appliedImpulseLateral1 = from.m_appliedImpulseLateral1;
  to.m_appliedImpulseLateral2 = from.m_appliedImpulseLateral2;
  to.m_prevRHS = from.m_prevRHS;
  to.m_userPersistentData = from.m_userPersistentData;
  to.m_lifeTime = from.m_lifeTime + 1;
}

// The direction along which this point's friction acts, not yet flattened onto its plane. Bullet's
// two rows are clamped each for itself, a square instead of Coulomb's circle; a first direction
// along the sliding, or, where nothing slides, along the force that friction held last step, makes
// the square touch the circle where it counts.
btVector3 wantedDirection(const ContactPoint& point, const PairSides& sides,
                          const btManifoldPoint* before, double slidingSpeed) {
  Vec3 slip = sides.motionA.at(point.position) - sides.motionB.at(point.position);
  slip -= slip.dot(point.normal) * point.normal;
  if (slip.norm() > slidingSpeed) return toBullet(slip);
  if (!before) return {0, 0, 0};
  const btVector3 held = before->m_lateralFrictionDir1 * before->m_appliedImpulseLateral1 +
                         before->m_lateralFrictionDir2 * before->m_appliedImpulseLateral2;
  const double limit = before->m_combinedFriction * before->m_appliedImpulse;
  return held.length() > kNearLimit * limit ? held : before->m_lateralFrictionDir1;
}

void setFrictionDirections(const ContactPoint& source, const PairSides& sides,
                           const btManifoldPoint* before, double slidingSpeed,
                           btManifoldPoint& point) {
  const btVector3& normal = point.m_normalWorldOnB;
  btVector3 along = wantedDirection(source, sides, before, slidingSpeed);
  const btScalar length = along.length();
  along -= normal * normal.dot(along);
  // What is left of a vector along the normal is rounding, not a direction.
  if (along.length() <= btScalar(1e-3) * length) {
    btPlaneSpace1(normal, point.m_lateralFrictionDir1, point.m_lateralFrictionDir2);
    return;
  }
  point.m_lateralFrictionDir1 = along.normalized();
  point.m_lateralFrictionDir2 = point.m_lateralFrictionDir1.cross(normal);
}

// A = B + normal * distance, both surfaces half the depth from the point.
void setGeometry(const ContactPoint& source, const PairSides& sides, btManifoldPoint& point) {
  const Vec3 half = source.depth / 2 * source.normal;
  point.m_positionWorldOnA = toBullet(Vec3(source.position + half));
  point.m_positionWorldOnB = toBullet(Vec3(source.position - half));
  point.m_normalWorldOnB = toBullet(Vec3(-source.normal));
  point.m_distance1 = static_cast<btScalar>(-source.depth);
  // In the bodies' frames, not the wrappers': a wrapper may be a compound's child.
  point.m_localPointA =
      sides.wrapA->getCollisionObject()->getWorldTransform().invXform(point.m_positionWorldOnA);
  point.m_localPointB =
      sides.wrapB->getCollisionObject()->getWorldTransform().invXform(point.m_positionWorldOnB);
}

void setLaw(const ContactPoint& source, double scale, btManifoldPoint& point) {
  point.m_combinedContactStiffness1 = static_cast<btScalar>(scale * source.stiffness);
  point.m_combinedContactDamping1 = static_cast<btScalar>(scale * source.damping);
}

bool wantsCallback(const PairSides& sides) {
  constexpr int kFlag = btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK;
  return gContactAddedCallback && ((sides.wrapA->getCollisionObject()->getCollisionFlags() |
                                    sides.wrapB->getCollisionObject()->getCollisionFlags()) &
                                   kFlag);
}

}  // namespace

ManifoldWriter::~ManifoldWriter() {
  for (btPersistentManifold* manifold : manifolds_) dispatcher_.releaseManifold(manifold);
}

void ManifoldWriter::remember() {
  old_.clear();
  for (const btPersistentManifold* manifold : manifolds_)
    for (int i = 0; i < manifold->getNumContacts(); ++i)
      old_.push_back(manifold->getContactPoint(i));
  std::sort(old_.begin(), old_.end(), [](const btManifoldPoint& a, const btManifoldPoint& b) {
    return a.m_partId0 < b.m_partId0;
  });
  inherited_.assign(old_.size(), 0);
}

const btManifoldPoint* ManifoldWriter::heirOf(int id) {
  auto found = std::lower_bound(
      old_.begin(), old_.end(), id,
      [](const btManifoldPoint& point, int wanted) { return point.m_partId0 < wanted; });
  // An id that came twice gives each of its two points one ancestor, never the same one.
  for (; found != old_.end() && found->m_partId0 == id; ++found) {
    char& taken = inherited_[found - old_.begin()];
    if (taken) continue;
    taken = 1;
    return &*found;
  }
  return nullptr;
}

void ManifoldWriter::fill(btPersistentManifold& manifold, const PairSides& sides,
                          const ContactResult& contact, const Patch& patch,
                          const btManifoldPoint& common, const WriteSettings& settings) {
  const int count = std::min(patch.points, MANIFOLD_CACHE_SIZE);
  manifold.setNumContacts(count);
  for (int i = 0; i < count; ++i) {
    const ContactPoint& source = contact.points[patch.firstPoint + i];
    btManifoldPoint& point = manifold.getContactPoint(i);
    point = common;
    setGeometry(source, sides, point);
    if (settings.law != LawForm::Rigid) setLaw(source, settings.stiffnessScale, point);
    point.m_partId0 = static_cast<int>(source.id);
    point.m_partId1 = source.patch;
    const btManifoldPoint* const before = heirOf(point.m_partId0);
    setFrictionDirections(source, sides, before, settings.slidingSpeed, point);
    if (before) copyLearnt(*before, point);
    if (before && gContactProcessedCallback)
      gContactProcessedCallback(point, const_cast<btCollisionObject*>(manifold.getBody0()),
                                const_cast<btCollisionObject*>(manifold.getBody1()));
    if (wantsCallback(sides))
      gContactAddedCallback(point, sides.wrapA, point.m_partId0, point.m_index0, sides.wrapB,
                            point.m_partId1, point.m_index1);
  }
}

void ManifoldWriter::dropWithoutHeir() {
  if (!gContactDestroyedCallback) return;
  for (std::size_t i = 0; i < old_.size(); ++i)
    if (!inherited_[i] && old_[i].m_userPersistentData)
      gContactDestroyedCallback(old_[i].m_userPersistentData);
}

void ManifoldWriter::clear() {
  for (btPersistentManifold* manifold : manifolds_) dispatcher_.clearManifold(manifold);
}

void ManifoldWriter::write(const PairSides& sides, const ContactResult& contact,
                           const WriteSettings& settings) {
  remember();
  const btManifoldPoint common = commonOf(sides, settings.law);
  const std::size_t patches = contact.patches.size();
  while (manifolds_.size() < patches) {
    btPersistentManifold* const manifold = dispatcher_.getNewManifold(
        sides.wrapA->getCollisionObject(), sides.wrapB->getCollisionObject());
    if (!manifold) break;  // Bullet's pool is full and told not to grow
    // btCompoundCollisionAlgorithm refreshes its children's manifolds, which drops points that
    // moved further than this: ours are rewritten anyway, and must not lose their impulses.
    manifold->setContactBreakingThreshold(BT_LARGE_FLOAT);
    manifolds_.push_back(manifold);
  }
  for (std::size_t i = 0; i < manifolds_.size(); ++i) {
    btPersistentManifold& manifold = *manifolds_[i];
    const bool touched = manifold.getNumContacts() > 0;
    const bool touches = i < patches && contact.patches[i].points > 0;
    if (touches)
      fill(manifold, sides, contact, contact.patches[i], common, settings);
    else
      manifold.setNumContacts(0);
    if (touches && !touched && gContactStartedCallback) {
      btPersistentManifold* started = &manifold;
      gContactStartedCallback(started);
    }
    if (touched && !touches && gContactEndedCallback) {
      btPersistentManifold* ended = &manifold;
      gContactEndedCallback(ended);
    }
  }
  dropWithoutHeir();
}

}  // namespace cloudcontact
