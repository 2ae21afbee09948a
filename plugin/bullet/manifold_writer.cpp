// Contact points to btManifoldPoint. Bullet's normal points from body 1 (our B) to body 0 (our A),
// the reverse of ours. m_partId0 holds the point's ID and m_partId1 its patch, for users to read;
// triangles have no such fields, since a patch may lie on many.
#include "bullet/manifold_writer.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>

#include <algorithm>

#include "bullet/convert.h"
#include "bullet/object_motion.h"
#include "bullet/point_friction.h"
#include "bullet/point_law.h"
#include "contact/first_touch.h"

namespace cloudcontact {

namespace {

// Fields that are equal for all points of a pair: Bullet's combined coefficients and flags.
btManifoldPoint commonOf(const PairSides& sides, bool rigid) {
  const btCollisionObject* const a = sides.wrapA->getCollisionObject();
  const btCollisionObject* const b = sides.wrapB->getCollisionObject();
  btManifoldPoint point;
  // Bullet makes vectors of anything, and writes and compares their unused fourth number at times.
  for (btVector3* v : {&point.m_localPointA, &point.m_localPointB, &point.m_positionWorldOnA,
                       &point.m_positionWorldOnB, &point.m_normalWorldOnB,
                       &point.m_lateralFrictionDir1, &point.m_lateralFrictionDir2})
    v->setZero();
  point.m_combinedFriction = gCalculateCombinedFrictionCallback(a, b);
  point.m_combinedRollingFriction = gCalculateCombinedRollingFrictionCallback(a, b);
  point.m_combinedSpinningFriction = gCalculateCombinedSpinningFrictionCallback(a, b);
  point.m_combinedRestitution = gCalculateCombinedRestitutionCallback(a, b);
  point.m_index0 = sides.wrapA->m_index;  // a compound's child
  point.m_index1 = sides.wrapB->m_index;
  point.m_contactPointFlags = 0;
  if (!rigid) point.m_contactPointFlags |= BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING;
  // Bullet chooses the directions of anisotropic friction itself.
  if (!a->hasAnisotropicFriction() && !b->hasAnisotropicFriction())
    point.m_contactPointFlags |= BT_CONTACT_FLAG_LATERAL_FRICTION_INITIALIZED;
  return point;
}

// What the solver knows of a point that lives on. Its friction turns with its directions.
void copySolverData(const btManifoldPoint& from, btManifoldPoint& to) {
  to.m_appliedImpulse = from.m_appliedImpulse;
  to.m_appliedImpulseLateral1 = from.m_appliedImpulseLateral1;
  to.m_appliedImpulseLateral2 = from.m_appliedImpulseLateral2;
  to.m_prevRHS = from.m_prevRHS;
  to.m_userPersistentData = from.m_userPersistentData;
  to.m_lifeTime = from.m_lifeTime + 1;
  if (from.m_lateralFrictionDir1 == to.m_lateralFrictionDir1) return;
  const btVector3 friction = from.m_lateralFrictionDir1 * from.m_appliedImpulseLateral1 +
                             from.m_lateralFrictionDir2 * from.m_appliedImpulseLateral2;
  to.m_appliedImpulseLateral1 = friction.dot(to.m_lateralFrictionDir1);
  to.m_appliedImpulseLateral2 = friction.dot(to.m_lateralFrictionDir2);
}

// Of a swept pair: where a place of its body at the touch is while the body is still where it is
// now, but has turned already. So impulses have the levers of the touch.
Vec3 broughtBack(const Vec3& place, const Motion& atTouch, const btCollisionObjectWrapper& wrap) {
  return place - atTouch.center +
         toVec3(wrap.getCollisionObject()->getWorldTransform().getOrigin());
}

// A = B + normal * distance, both surfaces half the depth from the point.
void setGeometry(const ContactPoint& source, const PairSides& sides, btManifoldPoint& point) {
  const Vec3 half = source.depth / 2 * source.normal;
  Vec3 onA = source.position + half, onB = source.position - half;
  double depth = source.depth;
  if (sides.touch) {
    onA = broughtBack(onA, sides.motionA, *sides.wrapA);
    onB = broughtBack(onB, sides.motionB, *sides.wrapB);
    const Vec3 meeting = sides.motionA.at(source.position) - sides.motionB.at(source.position);
    const double passing = meeting.dot(source.normal) - sides.touch->checked.dot(source.normal);
    depth -= passing * sides.touch->time;
  }
  point.m_positionWorldOnA = toBullet(onA);
  point.m_positionWorldOnB = toBullet(onB);
  point.m_normalWorldOnB = toBullet(Vec3(-source.normal));
  point.m_distance1 = static_cast<btScalar>(-depth);
  // In the bodies' frames, not the wrappers': a wrapper may be a compound's child.
  point.m_localPointA =
      sides.wrapA->getCollisionObject()->getWorldTransform().invXform(point.m_positionWorldOnA);
  point.m_localPointB =
      sides.wrapB->getCollisionObject()->getWorldTransform().invXform(point.m_positionWorldOnB);
}

// After Bullet's callbacks for a point. What they change holds: friction, stiffness and damping in
// the row, and the restitution that is returned. On top of a spring it would bounce twice
// (step_adjustments.h).
double announced(const btPersistentManifold& manifold, const PairSides& sides, bool known,
                 const WriteSettings& settings, btManifoldPoint& point) {
  auto* const a = const_cast<btCollisionObject*>(manifold.getBody0());
  auto* const b = const_cast<btCollisionObject*>(manifold.getBody1());
  if (known && gContactProcessedCallback) gContactProcessedCallback(point, a, b);
  const int flags = a->getCollisionFlags() | b->getCollisionFlags();
  if (gContactAddedCallback && (flags & btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK))
    gContactAddedCallback(point, sides.wrapA, point.m_partId0, point.m_index0, sides.wrapB,
                          point.m_partId1, point.m_index1);
  const double restitution = point.m_combinedRestitution;
  if (!settings.rigid) point.m_combinedRestitution = 0;
  return restitution;
}

Vec3 pullOf(const PairSides& sides) {
  return gravityOf(*sides.wrapA->getCollisionObject()) -
         gravityOf(*sides.wrapB->getCollisionObject());
}

// Whether all that touches within the step does so near its end.
bool touchesLate(const PairSides& sides, const ContactResult& contact,
                 const WriteSettings& settings) {
  const Vec3 pull = pullOf(sides);
  return std::all_of(contact.points.begin(), contact.points.end(), [&](const ContactPoint& source) {
    const StepPoint point{source, sides, settings, pull};
    return !point.touches() || point.touchesLate();
  });
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
  const auto byId = [](const btManifoldPoint& a, const btManifoldPoint& b) {
    return a.m_partId0 < b.m_partId0;
  };
  if (!std::is_sorted(old_.begin(), old_.end(), byId)) std::sort(old_.begin(), old_.end(), byId);
  inherited_.assign(old_.size(), 0);
}

const btManifoldPoint* ManifoldWriter::ancestorOf(int id) {
  auto found = std::lower_bound(
      old_.begin(), old_.end(), id,
      [](const btManifoldPoint& point, int wanted) { return point.m_partId0 < wanted; });
  // Two points with one ID get different ancestors.
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
                          const btManifoldPoint& common, const PointLaw& law,
                          const WriteSettings& settings) {
  const int count = std::min(patch.points, MANIFOLD_CACHE_SIZE);
  const ContactPoint* const sources = contact.points.data() + patch.firstPoint;
  const btManifoldPoint* before[MANIFOLD_CACHE_SIZE] = {};
  Vec3 slips[MANIFOLD_CACHE_SIZE];
  PatchLoad load;
  for (int i = 0; i < count; ++i) {
    before[i] = ancestorOf(static_cast<int>(sources[i].id));
    slips[i] = slipOf(sources[i], sides.motionA, sides.motionB);
    load.add(sources[i].position, before[i]);
  }
  const Vec3 pull = pullOf(sides);
  const bool bounces = std::any_of(sources, sources + count, [&](const ContactPoint& source) {
    return StepPoint{source, sides, settings, pull}.touches();
  });
  load.sum(sides.mass / static_cast<double>(contact.points.size()));
  manifold.setNumContacts(count);
  for (int i = 0; i < count; ++i) {
    btManifoldPoint& point = manifold.getContactPoint(i);
    point = common;
    setGeometry(sources[i], sides, point);
    if (!settings.rigid) law.write(sources[i], point);
    point.m_partId0 = static_cast<int>(sources[i].id);
    point.m_partId1 = sources[i].patch;
    setFrictionDirections(sources[i].position, slips[i], load, before[i], point);
    if (before[i]) copySolverData(*before[i], point);
    const double restitution = announced(manifold, sides, before[i] != nullptr, settings, point);
    adjust({sources[i], sides, settings, pull, bounces ? settings.together : 0, waits_, i == 0,
            before[i], restitution},
           point);
    Vec3 stretch = Vec3::Zero();
    if (before[i])
      stretch = FrictionSpring::of(*before[i], sides.mass, settings.step)
                    .stretched(*before[i], slips[i], settings.step);
    FrictionSpring::of(point, sides.mass, settings.step).write(stretch, sides.mass, point);
  }
}

void ManifoldWriter::reportDestroyed() {
  if (!gContactDestroyedCallback) return;
  for (std::size_t i = 0; i < old_.size(); ++i)
    if (!inherited_[i] && old_[i].m_userPersistentData)
      gContactDestroyedCallback(old_[i].m_userPersistentData);
}

// False if Bullet's pool is full and must not grow.
bool ManifoldWriter::addManifold(const btCollisionObject& a, const btCollisionObject& b) {
  btPersistentManifold* const manifold = dispatcher_.getNewManifold(&a, &b);
  if (!manifold) return false;
  // btCompoundCollisionAlgorithm refreshes its children's manifolds and drops points that moved
  // further than this. Our points are rewritten anyway and must keep their impulses.
  manifold->setContactBreakingThreshold(BT_LARGE_FLOAT);
  // SolverIslands sorts by it. Bullet does not use it.
  manifold->m_companionIdA = static_cast<int>(manifolds_.size());
  manifolds_.push_back(manifold);
  return true;
}

const std::vector<btPersistentManifold*>& ManifoldWriter::resize(std::size_t count,
                                                                 const btCollisionObject& a,
                                                                 const btCollisionObject& b) {
  for (; manifolds_.size() > count; manifolds_.pop_back())
    dispatcher_.releaseManifold(manifolds_.back());
  while (manifolds_.size() < count && addManifold(a, b)) {
  }
  return manifolds_;
}

void ManifoldWriter::clear() {
  for (btPersistentManifold* manifold : manifolds_) dispatcher_.clearManifold(manifold);
}

void ManifoldWriter::write(const PairSides& sides, const ContactResult& contact,
                           const WriteSettings& settings) {
  remember();
  const btManifoldPoint common = commonOf(sides, settings.rigid);
  const std::size_t patches = contact.patches.size();
  const PointLaw law(contact, sides, settings);
  waits_ = touchesLate(sides, contact, settings);
  while (manifolds_.size() < patches)
    if (!addManifold(*sides.wrapA->getCollisionObject(), *sides.wrapB->getCollisionObject())) break;
  for (std::size_t i = 0; i < manifolds_.size(); ++i) {
    btPersistentManifold& manifold = *manifolds_[i];
    const bool touched = manifold.getNumContacts() > 0;
    const bool touches = i < patches && contact.patches[i].points > 0;
    if (touches)
      fill(manifold, sides, contact, contact.patches[i], common, law, settings);
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
  reportDestroyed();
}

}  // namespace cloudcontact
