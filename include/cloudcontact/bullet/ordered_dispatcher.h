// OrderedDispatcher: Bullet's threads without chance in the result.
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObject.h>

#include <algorithm>
#include <array>

namespace cloudcontact {

// A dispatcher of Bullet's whose contacts come in the order of their pairs: OrderedDispatcher<
// btCollisionDispatcherMt> where Bullet is built with BT_THREADSAFE. That one lists new contacts in
// the order in which its threads find them, and what the solver makes of them depends on it; here
// any number of threads gives the same bits, those of OrderedDispatcher<btCollisionDispatcher>.
// CloudDispatcher needs no such order.
template <typename Dispatcher>
class OrderedDispatcher : public Dispatcher {
 public:
  using Dispatcher::Dispatcher;

  void dispatchAllCollisionPairs(btOverlappingPairCache* pairs, const btDispatcherInfo& info,
                                 btDispatcher* dispatcher) override {
    Dispatcher::dispatchAllCollisionPairs(pairs, info, dispatcher);
    btAlignedObjectArray<btPersistentManifold*>& all = this->m_manifoldsPtr;
    if (all.size() == 0) return;
    std::stable_sort(&all[0], &all[0] + all.size(),
                     [](const auto* a, const auto* b) { return keyOf(*a) < keyOf(*b); });
    for (int i = 0; i < all.size(); ++i) all[i]->m_index1a = i;
  }

 private:
  // The pair, the children of compounds, and the first point's ID or triangle.
  static std::array<int, 6> keyOf(const btPersistentManifold& manifold) {
    const auto idOf = [](const btCollisionObject& object) {
      const btBroadphaseProxy* const proxy = object.getBroadphaseHandle();
      return proxy ? proxy->m_uniqueId : -1;
    };
    std::array<int, 6> key = {
        idOf(*manifold.getBody0()), idOf(*manifold.getBody1()), -1, -1, -1, -1};
    if (manifold.getNumContacts() == 0) return key;
    const btManifoldPoint& point = manifold.getContactPoint(0);
    key = {key[0], key[1], point.m_index0, point.m_index1, point.m_partId0, point.m_partId1};
    return key;
  }
};

}  // namespace cloudcontact
