// CloudAlgorithm: what Bullet runs, once a step, for a pair with a CloudShape in it.
#pragma once

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>

#include <cloudcontact/contact/contact_finder.h>

#include <memory>

namespace cloudcontact {

class NarrowPhase;

class CloudAlgorithm : public btCollisionAlgorithm {
 public:
  CloudAlgorithm(const btCollisionAlgorithmConstructionInfo& info, NarrowPhase& narrowPhase);
  ~CloudAlgorithm() override;

  // Finds the pair's contact and writes it to the pair's own manifolds. Where `result` is not
  // Bullet's plain one but a query's (contactTest, contactPairTest), tells the query instead, and
  // leaves the manifolds alone.
  void processCollision(const btCollisionObjectWrapper* a, const btCollisionObjectWrapper* b,
                        const btDispatcherInfo& info, btManifoldResult* result) override;
  // Clouds have no continuous detection: 1, the whole step.
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override;
  void getAllContactManifolds(btManifoldArray& manifolds) override;

  // For CloudDispatcher: reads what processCollision() will ask in this step if nothing changes
  // until then. Returns about how many samples that will look up; 0: there is nothing to work out.
  std::size_t prepare(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                      const btDispatcherInfo& info) noexcept;
  // Finds the answer, which processCollision() takes if it asks just that. Different pairs may be
  // worked out at the same time; a large one may be shared out.
  void workOut(const TaskRunner* shareOut) noexcept;

  // Makes the algorithm in the dispatcher's pool.
  class Factory : public btCollisionAlgorithmCreateFunc {
   public:
    explicit Factory(NarrowPhase& narrowPhase) : narrowPhase_(narrowPhase) {}
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* a,
                                                   const btCollisionObjectWrapper* b) override;

   private:
    NarrowPhase& narrowPhase_;
  };

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
