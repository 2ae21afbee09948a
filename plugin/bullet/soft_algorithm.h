// SoftAlgorithm: Bullet's collision algorithm for a soft body and a CloudShape.
#pragma once

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>
#include <cloudcontact/bullet/soft_contact_point.h>

#include <memory>
#include <vector>

class btSoftBody;

namespace cloudcontact {

class NarrowPhase;

class SoftAlgorithm : public btCollisionAlgorithm {
 public:
  SoftAlgorithm(const btCollisionAlgorithmConstructionInfo& info, NarrowPhase& narrowPhase);
  ~SoftAlgorithm() override;

  // Finds the nodes that touch and applies impulses to them and to the rigid body. Queries
  // (contactTest) and calls between steps change nothing.
  void processCollision(const btCollisionObjectWrapper* a, const btCollisionObjectWrapper* b,
                        const btDispatcherInfo& info, btManifoldResult* result) override;
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override;
  void getAllContactManifolds(btManifoldArray&) override {}  // none: no solver rows

  // Appends the contacts of the last step, if this is the pair's soft body.
  void append(const btSoftBody& soft, std::vector<SoftContactPoint>& points) const;

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
