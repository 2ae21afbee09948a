// CloudAlgorithm: Bullet's collision algorithm for a pair with a CloudShape.
#pragma once

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>

#include <memory>
#include <vector>

#include "base/byte_archive.h"
#include "bullet/look_ahead.h"

namespace cloudcontact {

class NarrowPhase;
struct PairState;
struct CloudContactSettings;

class CloudAlgorithm : public btCollisionAlgorithm, public AheadPair {
 public:
  CloudAlgorithm(const btCollisionAlgorithmConstructionInfo& info, NarrowPhase& narrowPhase);
  ~CloudAlgorithm() override;

  const CloudContactSettings& settings() const;
  // Finds the contact and writes it to the pair's own manifolds. If `result` is a query's
  // (contactTest, contactPairTest) instead of Bullet's plain one, it gets the points and the
  // manifolds stay as they are.
  void processCollision(const btCollisionObjectWrapper* a, const btCollisionObjectWrapper* b,
                        const btDispatcherInfo& info, btManifoldResult* result) override;
  // Nothing in Bullet's worlds asks for it: 1, the whole step. See PairSweep.
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override;
  void getAllContactManifolds(btManifoldArray& manifolds) override;

  std::size_t prepare(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                      const btDispatcherInfo& info) noexcept override;
  void searchAhead(const TaskRunner* shareOut) noexcept override;
  SearchTask deviceTask() noexcept override;
  void searchedOnDevice(double seconds) noexcept override;
  bool finish(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
              const btDispatcherInfo& info) noexcept override;
  void reserve(int threads) override;

  // For files (contact_record.h): the pair, as its last query named it, null before the first; and
  // what its next step needs of its last one, beside its manifolds, of which restore() makes as
  // many.
  struct Name {
    const btCollisionObject *a = nullptr, *b = nullptr;
    int childA = -1, childB = -1;
  };
  Name name() const;
  void save(ByteWriter& writer) const;
  const std::vector<btPersistentManifold*>& restore(ByteReader& reader, std::size_t manifolds);

  // Makes the algorithm in the dispatcher's pool.
  class Factory : public AheadPairFactory {
   public:
    explicit Factory(NarrowPhase& narrowPhase) : narrowPhase_(narrowPhase) {}
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* a,
                                                   const btCollisionObjectWrapper* b) override;

   private:
    NarrowPhase& narrowPhase_;
  };

 private:
  static LookAhead* lookAheadOf(btDispatcher& dispatcher);  // of a CloudDispatcher, or null

  std::unique_ptr<PairState> state_;
};

}  // namespace cloudcontact
