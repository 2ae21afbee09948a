// Reads Bullet's manifolds after a step.
#include "scene/contacts_now.h"

#include "scene/bullet_vectors.h"

namespace cloudcontact::program {
namespace {

// The points' places are those of the step's start; the bodies have moved since, and a picture
// shows them where they are now.
Vec3 placeNow(const btManifoldPoint& point, const btCollisionObject& a,
              const btCollisionObject& b) {
  const btVector3 onA = a.getWorldTransform()(point.m_localPointA);
  const btVector3 onB = b.getWorldTransform()(point.m_localPointB);
  return 0.5 * (fromBullet(onA) + fromBullet(onB));
}

// Bullet's normals point from its second body to its first: along them it presses the first.
ContactNow contactOf(const btManifoldPoint& point, const btPersistentManifold& manifold,
                     double step) {
  const btVector3 onFirst = point.m_normalWorldOnB * point.m_appliedImpulse +
                            point.m_lateralFrictionDir1 * point.m_appliedImpulseLateral1 +
                            point.m_lateralFrictionDir2 * point.m_appliedImpulseLateral2;
  ContactNow now;
  now.position = placeNow(point, *manifold.getBody0(), *manifold.getBody1());
  now.normal = -fromBullet(point.m_normalWorldOnB);
  now.force = step > 0 ? Vec3(-fromBullet(onFirst) / step) : Vec3::Zero();
  now.depth = -point.getDistance();
  return now;
}

}  // namespace

void findContactsNow(btDispatcher& dispatcher, double step, ContactsNow& now) {
  now.patches.clear();
  now.points.clear();
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
    if (manifold.getNumContacts() == 0) continue;
    const auto points = static_cast<std::size_t>(manifold.getNumContacts());
    now.patches.push_back({manifold.getBody0()->getUserIndex(), manifold.getBody1()->getUserIndex(),
                           now.points.size(), points});
    for (int k = 0; k < manifold.getNumContacts(); ++k)
      now.points.push_back(contactOf(manifold.getContactPoint(k), manifold, step));
  }
}

}  // namespace cloudcontact::program
