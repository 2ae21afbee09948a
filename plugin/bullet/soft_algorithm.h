// SoftAlgorithm: what Bullet runs, once a step, for a soft body beside a CloudShape.
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

  // Finds the nodes that touch and gives them and the rigid body their impulses. Queries
  // (contactTest) and looks between steps change nothing.
  void processCollision(const btCollisionObjectWrapper* a, const btCollisionObjectWrapper* b,
                        const btDispatcherInfo& info, btManifoldResult* result) override;
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override;
  void getAllContactManifolds(btManifoldArray&) override {}  // Bullet's solver has no part in it

  // Adds what the last step did, where the pair's soft body is this one.
  void tell(const btSoftBody& soft, std::vector<SoftContactPoint>& points) const;

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
