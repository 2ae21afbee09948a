// One step of a soft pair. Exceptions end here, because Bullet is not exception-safe.
#include "bullet/soft_algorithm.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <cloudcontact/bullet/cloud_shape.h>

#include <chrono>
#include <exception>
#include <stdexcept>
#include <typeinfo>

#include "bullet/narrow_phase.h"
#include "bullet/soft_pair.h"

namespace cloudcontact {

static_assert(sizeof(SoftAlgorithm) <= 192);  // as CloudAlgorithm

namespace {
constexpr const char* kNoCloud =
    "a shape of CloudShape::kCloudType that is no CloudShape: give it another type";
}  // namespace

struct SoftAlgorithm::State {
  explicit State(NarrowPhase& shared) : narrowPhase(shared) {}
  void process(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b);

  NarrowPhase& narrowPhase;
  const btSoftBody* soft = nullptr;
  SoftPair pair;
};

void SoftAlgorithm::State::process(const btCollisionObjectWrapper& a,
                                   const btCollisionObjectWrapper& b) {
  const auto start = std::chrono::steady_clock::now();
  const bool first = a.getCollisionShape()->getShapeType() == SOFTBODY_SHAPE_PROXYTYPE;
  const btCollisionObjectWrapper &softSide = first ? a : b, &cloudSide = first ? b : a;
  // Bullet passes const objects to its algorithms that they have to change.
  auto* const cloudObject = const_cast<btCollisionObject*>(cloudSide.getCollisionObject());
  auto* const body =
      static_cast<btSoftBody*>(const_cast<btCollisionObject*>(softSide.getCollisionObject()));
  const auto lock = narrowPhase.lockToPush();
  soft = body;
  const auto& apart = body->m_collisionDisabledObjects;
  if (!body->hasContactResponse() || !cloudObject->hasContactResponse() ||
      apart.findLinearSearch(cloudObject) != apart.size())
    return pair.noContact();
  validate(*body);
  if (!steppedSince(*body, cloudSide)) return;
  const CloudShape* const cloud = CloudShape::of(*cloudSide.getCollisionShape());
  if (!cloud) throw std::runtime_error(kNoCloud);
  const CloudShape& shape = *cloud;
  const PairLaw law = lawOf(narrowPhase.settings(), cloudSide, softSide, shape.cloud().voxelSize(),
                            body->m_sst.sdt);
  const bool vectors = shape.usesPaper();
  pair.step(*body, {&cloudSide, btRigidBody::upcast(cloudObject)}, law, vectors);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  narrowPhase.count(elapsed.count(), static_cast<std::size_t>(body->m_nodes.size()),
                    pair.contacts()->size());
}

SoftAlgorithm::SoftAlgorithm(const btCollisionAlgorithmConstructionInfo& info,
                             NarrowPhase& narrowPhase)
    : btCollisionAlgorithm(info), state_(std::make_unique<State>(narrowPhase)) {
  narrowPhase.add(*this);
}

SoftAlgorithm::~SoftAlgorithm() {
  state_->narrowPhase.remove(*this);
}

void SoftAlgorithm::processCollision(const btCollisionObjectWrapper* a,
                                     const btCollisionObjectWrapper* b, const btDispatcherInfo&,
                                     btManifoldResult* result) {
  if (typeid(*result) != typeid(btManifoldResult)) return;
  try {
    state_->process(*a, *b);
    return;
  } catch (const std::exception& failure) {
    state_->narrowPhase.countFailure(failure.what());
  } catch (...) {
    state_->narrowPhase.countFailure("unknown failure in a soft body's contact");
  }
}

btScalar SoftAlgorithm::calculateTimeOfImpact(btCollisionObject*, btCollisionObject*,
                                              const btDispatcherInfo&, btManifoldResult*) {
  return 1;
}

void SoftAlgorithm::append(const btSoftBody& soft, std::vector<SoftContactPoint>& points) const {
  if (&soft == state_->soft) state_->pair.append(points);
}

btCollisionAlgorithm* SoftAlgorithm::Factory::CreateCollisionAlgorithm(
    btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper*,
    const btCollisionObjectWrapper*) {
  void* const memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(SoftAlgorithm));
  return new (memory) SoftAlgorithm(info, narrowPhase_);
}

}  // namespace cloudcontact
