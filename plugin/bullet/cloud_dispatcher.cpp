// Finds the cloud pairs of a step, as Bullet's default near callback will find them.
#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <cloudcontact/bullet/cloud_dispatcher.h>
#include <cloudcontact/bullet/cloud_shape.h>

#include <stdexcept>
#include <thread>

#include "bullet/look_ahead.h"

namespace cloudcontact {

namespace {

int countOf(int threads) {
  if (threads < 0)
    throw std::invalid_argument("CloudDispatcher: threads must not be negative; 0 means all cores");
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  return threads > 0 ? threads : std::max(1, cores);
}

std::unique_ptr<DeviceSearch> deviceOf(const CloudDispatcherSettings& settings) {
  if (settings.backend == Backend::Cpu) return nullptr;
  try {
    return std::make_unique<DeviceSearch>(
        BatchSettings{settings.backend, settings.threads, settings.timing});
  } catch (const std::runtime_error& e) {
    throw std::runtime_error(std::string(e.what()) +
                             " (CloudDispatcherSettings::backend asks for a device; Backend::Cpu "
                             "needs none)");
  }
}

bool isCloud(const btCollisionObject& object) {
  return CloudShape::of(*object.getCollisionShape()) != nullptr;
}

bool isSoft(const btCollisionObject& object) {
  return object.getInternalType() == btCollisionObject::CO_SOFT_BODY;
}

bool isCompound(const btCollisionObject& object) {
  return object.getCollisionShape()->isCompound();
}

// Whether no function of the user's wants to be called for a pair or a point in the walk's order,
// and on its thread.
bool noCallbacks() {
  using Result = btManifoldResult;
  return !gContactAddedCallback && !gContactProcessedCallback && !gContactStartedCallback &&
         !gContactEndedCallback && !gContactDestroyedCallback &&
         gCalculateCombinedFrictionCallback == &Result::calculateCombinedFriction &&
         gCalculateCombinedRestitutionCallback == &Result::calculateCombinedRestitution &&
         gCalculateCombinedRollingFrictionCallback == &Result::calculateCombinedRollingFriction &&
         gCalculateCombinedSpinningFrictionCallback == &Result::calculateCombinedSpinningFriction;
}

}  // namespace

CloudDispatcher::CloudDispatcher(btCollisionConfiguration* configuration, int threads)
    : CloudDispatcher(configuration, CloudDispatcherSettings{.threads = threads}) {}

CloudDispatcher::CloudDispatcher(btCollisionConfiguration* configuration,
                                 const CloudDispatcherSettings& settings)
    : btCollisionDispatcher(configuration),
      lookAhead_(std::make_unique<LookAhead>(countOf(settings.threads), deviceOf(settings),
                                             settings.leastForDevice)) {}

CloudDispatcher::~CloudDispatcher() = default;

int CloudDispatcher::threads() const {
  return lookAhead_->threads();
}

CloudDispatcherStatistics CloudDispatcher::statistics() const {
  return {lookAhead_->searched(),     lookAhead_->taken(),       lookAhead_->written(),
          lookAhead_->deviceReport(), lookAhead_->deviceSteps(), lookAhead_->deviceFailure()};
}

std::string CloudDispatcher::device() const {
  return lookAhead_->device() ? lookAhead_->device()->device() : std::string();
}

std::map<std::string, DeviceTime> CloudDispatcher::deviceTimes() {
  if (!lookAhead_->device()) return {};
  return lookAhead_->device()->deviceTimes();
}

// Returns whether the walk meets a soft body, which changes velocities on the way.
bool CloudDispatcher::gather(btOverlappingPairCache& pairs, const btDispatcherInfo& info) {
  bool soft = false;
  for (int i = 0; i < pairs.getNumOverlappingPairs(); ++i) {
    btBroadphasePair& pair = pairs.getOverlappingPairArrayPtr()[i];
    const auto& a = *static_cast<const btCollisionObject*>(pair.m_pProxy0->m_clientObject);
    const auto& b = *static_cast<const btCollisionObject*>(pair.m_pProxy1->m_clientObject);
    soft = soft || isSoft(a) || isSoft(b);
    const bool compound = isCompound(a) || isCompound(b);
    if (!compound && !isCloud(a) && !isCloud(b)) continue;
    if (!needsCollision(&a, &b)) continue;
    const btCollisionObjectWrapper wrapA(nullptr, a.getCollisionShape(), &a, a.getWorldTransform(),
                                         -1, -1);
    const btCollisionObjectWrapper wrapB(nullptr, b.getCollisionShape(), &b, b.getWorldTransform(),
                                         -1, -1);
    if (compound) {
      lookAhead_->addChildren(wrapA, wrapB, info);
      continue;
    }
    // A cloud pair's algorithm is made here as the callback would make it.
    if (!pair.m_algorithm && getNearCallback() == defaultNearCallback) {
      auto* const maker = m_doubleDispatchContactPoints[a.getCollisionShape()->getShapeType()]
                                                       [b.getCollisionShape()->getShapeType()];
      if (dynamic_cast<AheadPairFactory*>(maker))
        pair.m_algorithm = findAlgorithm(&wrapA, &wrapB, nullptr, BT_CONTACT_POINT_ALGORITHMS);
    }
    if (auto* const ahead = dynamic_cast<AheadPair*>(pair.m_algorithm))
      lookAhead_->add(*ahead, a, b);
  }
  return soft;
}

void CloudDispatcher::dispatchAllCollisionPairs(btOverlappingPairCache* pairs,
                                                const btDispatcherInfo& info,
                                                btDispatcher* dispatcher) {
  if ((threads() > 1 || lookAhead_->device()) &&
      info.m_dispatchFunc == btDispatcherInfo::DISPATCH_DISCRETE) {
    // Bullet is not exception-safe; its walk searches the pairs that fail here.
    try {
      lookAhead_->begin();
      const bool soft = gather(*pairs, info);
      lookAhead_->search(info);
      if (threads() > 1 && !soft && getNearCallback() == defaultNearCallback && noCallbacks())
        lookAhead_->finish(info);
    } catch (...) {
    }
  }
  btCollisionDispatcher::dispatchAllCollisionPairs(pairs, info, dispatcher);
  lookAhead_->end();
}

}  // namespace cloudcontact
