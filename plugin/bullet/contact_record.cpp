// Contacts to bytes and back.
#include "bullet/contact_record.h"

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/Dynamics/btDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "base/byte_archive.h"
#include "bullet/cloud_algorithm.h"
#include "bullet/narrow_phase.h"

namespace cloudcontact {

namespace {

constexpr std::int32_t kNobody = -1;
using Manifolds = std::vector<btPersistentManifold*>;

struct PairName {
  std::int32_t a = kNobody, b = kNobody;
  std::int32_t childA = -1, childB = -1;
  auto operator<=>(const PairName&) const = default;
};

// Whose a manifold is: the nth of a pair with a cloud, or of two bodies that meet by Bullet's own
// algorithms.
struct ManifoldName {
  std::int32_t cloudPair = -1;  // in ContactsRecord::pairs
  std::int32_t a = kNobody, b = kNobody;
  std::uint32_t nth = 0;
};

struct CloudPair {
  PairName name;
  std::uint32_t nth = 0;  // of its name
  std::string memory;
  std::uint32_t manifolds = 0;
};

// A pair of the broad phase.
struct Overlap {
  std::int32_t a = kNobody, b = kNobody;
  bool met = false;  // it has an algorithm
};

struct ContactsRecord {
  std::vector<Overlap> overlaps;  // in the order of the broad phase
  std::vector<CloudPair> pairs;
  // In the dispatcher's order.
  std::vector<std::pair<ManifoldName, std::vector<btManifoldPoint>>> manifolds;
};

template <typename Archive>
void vectorIn(Archive& archive, btVector3& v) {
  archive(v[0], v[1], v[2]);
  v[3] = 0;  // unused, but Bullet compares it
}

template <typename Archive>
void pointIn(Archive& archive, btManifoldPoint& p) {
  for (btVector3* v :
       {&p.m_localPointA, &p.m_localPointB, &p.m_positionWorldOnA, &p.m_positionWorldOnB,
        &p.m_normalWorldOnB, &p.m_lateralFrictionDir1, &p.m_lateralFrictionDir2})
    vectorIn(archive, *v);
  archive(p.m_distance1, p.m_combinedFriction, p.m_combinedRollingFriction,
          p.m_combinedSpinningFriction, p.m_combinedRestitution, p.m_partId0, p.m_partId1,
          p.m_index0, p.m_index1, p.m_contactPointFlags, p.m_appliedImpulse, p.m_prevRHS,
          p.m_appliedImpulseLateral1, p.m_appliedImpulseLateral2, p.m_contactMotion1,
          p.m_contactMotion2, p.m_combinedContactStiffness1, p.m_combinedContactDamping1,
          p.m_frictionCFM, p.m_lifeTime);
}

template <typename Archive>
void recordIn(Archive& archive, ContactsRecord& record) {
  listIn(archive, record.overlaps, [](Archive& a, Overlap& pair) { a(pair.a, pair.b, pair.met); });
  listIn(archive, record.pairs, [](Archive& a, CloudPair& pair) {
    a(pair.name.a, pair.name.b, pair.name.childA, pair.name.childB, pair.nth, pair.memory,
      pair.manifolds);
  });
  listIn(archive, record.manifolds, [](Archive& a, auto& manifold) {
    ManifoldName& name = manifold.first;
    a(name.cloudPair, name.a, name.b, name.nth);
    listIn(a, manifold.second, [](Archive& b, btManifoldPoint& point) { pointIn(b, point); });
  });
}

// The ranks of rigid bodies.
class Ranks {
 public:
  explicit Ranks(const btDynamicsWorld& world) {
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i)
      if (btRigidBody::upcast(objects[i])) add(*objects[i]);
  }
  explicit Ranks(const std::vector<btRigidBody*>& bodies) {
    for (const btRigidBody* body : bodies) add(*body);
  }
  std::int32_t of(const void* object) const {
    const auto found = ranks_.find(object);
    return found == ranks_.end() ? kNobody : found->second;
  }

 private:
  void add(const btCollisionObject& object) {
    ranks_.emplace(&object, static_cast<std::int32_t>(ranks_.size()));
  }
  std::map<const void*, std::int32_t> ranks_;
};

// The pairs with clouds that a file can name, by their names.
std::vector<std::pair<CloudPair, CloudAlgorithm*>> cloudPairs(const NarrowPhase& clouds,
                                                              const Ranks& ranks) {
  std::vector<std::pair<CloudPair, CloudAlgorithm*>> all;
  std::map<PairName, std::uint32_t> count;
  for (CloudAlgorithm* algorithm : clouds.algorithms()) {
    const CloudAlgorithm::Name name = algorithm->name();
    CloudPair pair;
    pair.name = {ranks.of(name.a), ranks.of(name.b), name.childA, name.childB};
    if (pair.name.a == kNobody || pair.name.b == kNobody) continue;
    pair.nth = count[pair.name]++;
    all.emplace_back(std::move(pair), algorithm);
  }
  const auto place = [](const auto& one) { return std::pair(one.first.name, one.first.nth); };
  std::sort(all.begin(), all.end(),
            [&](const auto& one, const auto& other) { return place(one) < place(other); });
  return all;
}

Manifolds manifoldsOf(CloudAlgorithm& algorithm) {
  btManifoldArray found;
  algorithm.getAllContactManifolds(found);
  Manifolds all;
  for (int i = 0; i < found.size(); ++i) all.push_back(found[i]);
  return all;
}

Manifolds manifoldsIn(btDispatcher& dispatcher) {
  Manifolds all;
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
    all.push_back(dispatcher.getManifoldByIndexInternal(i));
  return all;
}

// Counts the manifolds of two bodies' own pairs.
class OwnManifolds {
 public:
  explicit OwnManifolds(const Ranks& ranks) : ranks_(ranks) {}
  ManifoldName next(const btPersistentManifold& manifold) {
    ManifoldName name;
    name.a = ranks_.of(manifold.getBody0());
    name.b = ranks_.of(manifold.getBody1());
    name.nth = count_[{name.a, name.b}]++;
    return name;
  }

 private:
  const Ranks& ranks_;
  std::map<std::pair<std::int32_t, std::int32_t>, std::uint32_t> count_;
};

void setPoints(btPersistentManifold& manifold, const std::vector<btManifoldPoint>& points) {
  const int count = std::min<int>(static_cast<int>(points.size()), MANIFOLD_CACHE_SIZE);
  manifold.setNumContacts(count);
  for (int i = 0; i < count; ++i) manifold.getContactPoint(i) = points[std::size_t(i)];
}

// The overlapping pairs in the order of the record, with the algorithms that they have. `others`:
// those that the record does not have follow; without, only those of what is no rigid body do.
void orderOverlaps(btDynamicsWorld& world, const std::vector<btRigidBody*>& bodies,
                   const ContactsRecord& record, bool others) {
  btOverlappingPairCache& cache = *world.getPairCache();
  btDispatcher* const dispatcher = world.getDispatcher();
  std::vector<btBroadphasePair> known;
  const btBroadphasePairArray& array = cache.getOverlappingPairArray();
  for (int i = 0; i < array.size(); ++i) known.push_back(array[i]);
  std::map<std::pair<const void*, const void*>, btCollisionAlgorithm*> algorithms;
  for (const btBroadphasePair& pair : known) {
    algorithms[{pair.m_pProxy0, pair.m_pProxy1}] =
        std::exchange(cache.findPair(pair.m_pProxy0, pair.m_pProxy1)->m_algorithm, nullptr);
    cache.removeOverlappingPair(pair.m_pProxy0, pair.m_pProxy1, dispatcher);
  }
  const auto add = [&](btBroadphaseProxy* a, btBroadphaseProxy* b) {
    btBroadphasePair* const pair = cache.addOverlappingPair(a, b);
    if (!pair) return;
    const auto kept = algorithms.find({pair->m_pProxy0, pair->m_pProxy1});
    if (kept != algorithms.end()) pair->m_algorithm = std::exchange(kept->second, nullptr);
  };
  for (const Overlap& pair : record.overlaps)
    add(bodies.at(std::size_t(pair.a))->getBroadphaseProxy(),
        bodies.at(std::size_t(pair.b))->getBroadphaseProxy());
  const Ranks ranks(bodies);
  for (const btBroadphasePair& pair : known) {
    const bool named = ranks.of(pair.m_pProxy0->m_clientObject) != kNobody &&
                       ranks.of(pair.m_pProxy1->m_clientObject) != kNobody;
    if ((others || !named) && !cache.findPair(pair.m_pProxy0, pair.m_pProxy1))
      add(pair.m_pProxy0, pair.m_pProxy1);
  }
  for (const auto& [proxies, algorithm] : algorithms) {
    if (!algorithm) continue;
    algorithm->~btCollisionAlgorithm();
    dispatcher->freeCollisionAlgorithm(algorithm);
  }
}

// Pairs that had not met yet when they were saved, and those that were not there.
void forgetOthers(btDynamicsWorld& world, const std::vector<btRigidBody*>& bodies,
                  const ContactsRecord& record) {
  std::set<std::pair<const void*, const void*>> met;
  for (const Overlap& pair : record.overlaps)
    if (pair.met)
      met.insert(
          std::minmax<const void*>(bodies[std::size_t(pair.a)], bodies[std::size_t(pair.b)]));
  btOverlappingPairCache& cache = *world.getPairCache();
  for (int i = 0; i < cache.getNumOverlappingPairs(); ++i) {
    btBroadphasePair& pair = cache.getOverlappingPairArrayPtr()[i];
    const std::pair<const void*, const void*> both =
        std::minmax(pair.m_pProxy0->m_clientObject, pair.m_pProxy1->m_clientObject);
    if (!met.contains(both)) cache.cleanOverlappingPair(pair, world.getDispatcher());
  }
}

// The dispatcher's manifolds in this order, and others after them.
void orderManifolds(btDispatcher& dispatcher, const Manifolds& ordered) {
  Manifolds all = ordered;
  const std::set<const btPersistentManifold*> named(ordered.begin(), ordered.end());
  for (btPersistentManifold* manifold : manifoldsIn(dispatcher))
    if (!named.contains(manifold)) all.push_back(manifold);
  btPersistentManifold** const places = dispatcher.getInternalManifoldPointer();
  for (std::size_t i = 0; i < all.size(); ++i) {
    places[i] = all[i];
    all[i]->m_index1a = static_cast<int>(i);
  }
}

// The manifolds of the pairs with clouds, as many as the file has; empty for pairs that are gone.
std::vector<Manifolds> restorePairs(const NarrowPhase& clouds, const Ranks& ranks,
                                    const ContactsRecord& record) {
  std::map<std::pair<PairName, std::uint32_t>, CloudAlgorithm*> known;
  for (auto& [pair, algorithm] : cloudPairs(clouds, ranks))
    known[{pair.name, pair.nth}] = algorithm;
  std::vector<Manifolds> all;
  for (const CloudPair& pair : record.pairs) {
    all.emplace_back();
    const auto found = known.find({pair.name, pair.nth});
    if (found == known.end()) continue;
    ByteReader memory(pair.memory);
    all.back() = found->second->restore(memory, pair.manifolds);
  }
  return all;
}

// The manifolds of a world by the names of a file.
class KnownManifolds {
 public:
  KnownManifolds(btDispatcher& dispatcher, const NarrowPhase& clouds,
                 const std::vector<btRigidBody*>& bodies, const ContactsRecord& record) {
    const Ranks ranks(bodies);
    ofPairs_ = restorePairs(clouds, ranks, record);
    std::set<const btPersistentManifold*> ours;
    for (CloudAlgorithm* algorithm : clouds.algorithms())
      for (const btPersistentManifold* manifold : manifoldsOf(*algorithm)) ours.insert(manifold);
    OwnManifolds own(ranks);
    for (btPersistentManifold* manifold : manifoldsIn(dispatcher)) {
      if (ours.contains(manifold)) continue;
      const ManifoldName name = own.next(*manifold);
      ofBullet_[{name.a, name.b, name.nth}] = manifold;
    }
  }

  // Null if it is not there, or taken.
  btPersistentManifold* take(const ManifoldName& name) {
    btPersistentManifold* found = nullptr;
    if (name.cloudPair < 0) {
      const auto place = ofBullet_.find({name.a, name.b, name.nth});
      if (place != ofBullet_.end()) found = std::exchange(place->second, nullptr);
    } else if (std::size_t(name.cloudPair) < ofPairs_.size()) {
      Manifolds& all = ofPairs_[std::size_t(name.cloudPair)];
      if (name.nth < all.size()) found = std::exchange(all[name.nth], nullptr);
    }
    return found;
  }

 private:
  std::vector<Manifolds> ofPairs_;
  std::map<std::array<std::int64_t, 3>, btPersistentManifold*> ofBullet_;
};

// Whether all that the record names is in the world, where its pairs are.
bool isThere(btDynamicsWorld& world, const NarrowPhase& clouds,
             const std::vector<btRigidBody*>& bodies, const ContactsRecord& record) {
  btOverlappingPairCache& cache = *world.getPairCache();
  for (const Overlap& pair : record.overlaps) {
    const btBroadphasePair* const now =
        cache.findPair(bodies[std::size_t(pair.a)]->getBroadphaseProxy(),
                       bodies[std::size_t(pair.b)]->getBroadphaseProxy());
    if (pair.met && !(now && now->m_algorithm)) return false;
  }
  const Ranks ranks(bodies);
  std::set<std::pair<PairName, std::uint32_t>> pairs;
  std::set<const btPersistentManifold*> ours;
  for (const auto& [pair, algorithm] : cloudPairs(clouds, ranks)) {
    pairs.emplace(pair.name, pair.nth);
    for (const btPersistentManifold* manifold : manifoldsOf(*algorithm)) ours.insert(manifold);
  }
  for (const CloudPair& pair : record.pairs)
    if (!pairs.contains({pair.name, pair.nth})) return false;
  std::set<std::array<std::int64_t, 3>> own;
  OwnManifolds names(ranks);
  for (const btPersistentManifold* manifold : manifoldsIn(*world.getDispatcher())) {
    if (ours.contains(manifold)) continue;
    const ManifoldName name = names.next(*manifold);
    own.insert({name.a, name.b, name.nth});
  }
  for (const auto& [name, points] : record.manifolds)
    if (name.cloudPair < 0 && !own.contains({name.a, name.b, name.nth})) return false;
  return true;
}

// Makes the algorithms of pairs, and what they keep. A broad phase that is restored stays as it is:
// it may be about to drop pairs that the record has.
void findContacts(btDynamicsWorld& world, bool movesBoxes) {
  if (movesBoxes) return world.performDiscreteCollisionDetection();
  btDispatcher& dispatcher = *world.getDispatcher();
  dispatcher.dispatchAllCollisionPairs(world.getPairCache(), world.getDispatchInfo(), &dispatcher);
}

// The file's numbers of manifolds: as many are made as it says, so each must have a place in its
// list.
void requireListed(const ContactsRecord& record) {
  std::vector<std::size_t> listed(record.pairs.size());
  for (const auto& [name, points] : record.manifolds)
    if (name.cloudPair >= 0 && std::size_t(name.cloudPair) < listed.size())
      ++listed[std::size_t(name.cloudPair)];
  for (std::size_t i = 0; i < listed.size(); ++i)
    if (record.pairs[i].manifolds > listed[i])
      throw std::runtime_error("contacts name a manifold that is not there");
}

}  // namespace

std::string contactsOf(btDynamicsWorld& world, const NarrowPhase& clouds) {
  const Ranks ranks(world);
  ContactsRecord record;
  const btBroadphasePairArray& overlaps = world.getPairCache()->getOverlappingPairArray();
  for (int i = 0; i < overlaps.size(); ++i) {
    const std::int32_t a = ranks.of(overlaps[i].m_pProxy0->m_clientObject);
    const std::int32_t b = ranks.of(overlaps[i].m_pProxy1->m_clientObject);
    if (a != kNobody && b != kNobody)
      record.overlaps.push_back({a, b, overlaps[i].m_algorithm != nullptr});
  }
  std::map<const btPersistentManifold*, ManifoldName> names;
  for (auto& [pair, algorithm] : cloudPairs(clouds, ranks)) {
    ByteWriter memory;
    algorithm->save(memory);
    pair.memory = memory.bytes();
    ManifoldName name;
    name.cloudPair = static_cast<std::int32_t>(record.pairs.size());
    for (const btPersistentManifold* manifold : manifoldsOf(*algorithm)) {
      names[manifold] = name;
      name.nth = ++pair.manifolds;
    }
    record.pairs.push_back(pair);
  }
  OwnManifolds own(ranks);
  for (const btPersistentManifold* manifold : manifoldsIn(*world.getDispatcher())) {
    const auto found = names.find(manifold);
    const ManifoldName name = found == names.end() ? own.next(*manifold) : found->second;
    if (name.cloudPair < 0 && (name.a == kNobody || name.b == kNobody)) continue;
    std::vector<btManifoldPoint> points;
    for (int i = 0; i < manifold->getNumContacts(); ++i)
      points.push_back(manifold->getContactPoint(i));
    record.manifolds.emplace_back(name, std::move(points));
  }
  ByteWriter writer;
  recordIn(writer, record);
  return writer.bytes();
}

void checkContacts(std::span<const char> bytes, std::size_t bodies) {
  ContactsRecord record;
  ByteReader reader(bytes);
  recordIn(reader, record);
  const auto isBody = [&](std::int32_t rank) { return rank >= 0 && std::size_t(rank) < bodies; };
  for (const Overlap& pair : record.overlaps)
    if (!isBody(pair.a) || !isBody(pair.b))
      throw std::runtime_error("contacts name a body that is not there");
  requireListed(record);
}

void restoreContacts(btDynamicsWorld& world, const NarrowPhase& clouds,
                     const std::vector<btRigidBody*>& bodies, std::span<const char> bytes,
                     const std::function<void()>& restorePhase) {
  checkContacts(bytes, bodies.size());
  ContactsRecord record;
  ByteReader reader(bytes);
  recordIn(reader, record);
  if (restorePhase) restorePhase();
  orderOverlaps(world, bodies, record, !restorePhase);
  if (!isThere(world, clouds, bodies, record)) findContacts(world, restorePhase == nullptr);
  forgetOthers(world, bodies, record);
  KnownManifolds known(*world.getDispatcher(), clouds, bodies, record);
  Manifolds ordered;
  for (const auto& [name, points] : record.manifolds) {
    btPersistentManifold* const manifold = known.take(name);
    if (!manifold) continue;
    setPoints(*manifold, points);
    ordered.push_back(manifold);
  }
  orderManifolds(*world.getDispatcher(), ordered);
}

}  // namespace cloudcontact
