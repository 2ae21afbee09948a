// CloudDispatcher: Bullet's own dispatcher, with a step's cloud pairs worked out on all cores. One
// line of a program changes:
//
//   cloudcontact::CloudDispatcher dispatcher(&configuration);  // was btCollisionDispatcher
//   contact.attach(dispatcher);                                // as before
//
// Manifolds, their order and every bit in them are those of btCollisionDispatcher, for any number
// of threads: pairs are only looked for ahead of Bullet's own serial walk over them, which then
// takes each answer if it was found for exactly what the walk asks, and otherwise finds it on the
// spot. Callbacks come from that walk, as ever, in its order and its thread.
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>

#include <cstddef>
#include <memory>

namespace cloudcontact {

class LookAhead;

// Since the dispatcher was made.
struct CloudDispatcherStatistics {
  std::size_t ahead = 0;  // pairs worked out ahead of Bullet's walk
  std::size_t taken = 0;  // and of these the answers that it took
};

class CloudDispatcher : public btCollisionDispatcher {
 public:
  // `threads`, the caller's among them; 0: all cores; 1: nothing is done ahead. Throws
  // std::invalid_argument where it is negative.
  explicit CloudDispatcher(btCollisionConfiguration* configuration, int threads = 0);
  ~CloudDispatcher() override;

  int threads() const;
  CloudDispatcherStatistics statistics() const;

  // Pairs are looked for ahead where Bullet's own near callback is in place, and with another one
  // those that it let pass in the step before. needsCollision() may be asked twice a pair. Pairs
  // with children of compounds are from their second step on.
  void dispatchAllCollisionPairs(btOverlappingPairCache* pairs, const btDispatcherInfo& info,
                                 btDispatcher* dispatcher) override;

 private:
  friend class CloudAlgorithm;
  void gather(btOverlappingPairCache& pairs, const btDispatcherInfo& info);

  std::unique_ptr<LookAhead> lookAhead_;
};

}  // namespace cloudcontact
