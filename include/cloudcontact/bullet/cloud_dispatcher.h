// CloudDispatcher: Bullet's own dispatcher, which computes a step's cloud pairs on all cores. One
// line of a program changes:
//
//   cloudcontact::CloudDispatcher dispatcher(&configuration);  // was btCollisionDispatcher
//   contact.attach(dispatcher);                                // as before
//
// Manifolds, their order and every bit in them equal those of btCollisionDispatcher, for any number
// of threads. Pairs are searched ahead of Bullet's serial walk over them. The walk takes a result
// if the query has not changed since, and otherwise searches again. Callbacks still come from the
// walk, in its order and on its thread.
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>

#include <cstddef>
#include <memory>

namespace cloudcontact {

class LookAhead;

// Since the dispatcher was made.
struct CloudDispatcherStatistics {
  std::size_t ahead = 0;  // pairs searched ahead of Bullet's walk
  std::size_t taken = 0;  // results of these that the walk used
};

class CloudDispatcher : public btCollisionDispatcher {
 public:
  // `threads` includes the caller's; 0: all cores; 1: no search ahead. Throws std::invalid_argument
  // if it is negative.
  explicit CloudDispatcher(btCollisionConfiguration* configuration, int threads = 0);
  ~CloudDispatcher() override;

  int threads() const;
  CloudDispatcherStatistics statistics() const;

  // With Bullet's own near callback all pairs are searched ahead; with another one, those that it
  // processed in the step before, as are the children of compounds. needsCollision() may be called
  // twice per pair.
  void dispatchAllCollisionPairs(btOverlappingPairCache* pairs, const btDispatcherInfo& info,
                                 btDispatcher* dispatcher) override;

 private:
  friend class CloudAlgorithm;
  void gather(btOverlappingPairCache& pairs, const btDispatcherInfo& info);

  std::unique_ptr<LookAhead> lookAhead_;
};

}  // namespace cloudcontact
