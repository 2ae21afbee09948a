// Finds the cloud pairs of a step, as Bullet's default near callback will find them.
#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <cloudcontact/bullet/cloud_dispatcher.h>
#include <cloudcontact/bullet/cloud_shape.h>

#include <stdexcept>
#include <thread>
#include <typeinfo>

#include "bullet/look_ahead.h"

namespace cloudcontact {

// What one of Bullet's pairs is to the search ahead.
struct CloudDispatcher::Gathered {
  enum { None, Soft, Compound, New, Known } kind = None;
  AheadPair* pair = nullptr;
};

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

namespace {

const btCollisionObject& objectOf(const btBroadphaseProxy& proxy) {
  return *static_cast<const btCollisionObject*>(proxy.m_clientObject);
}

}  // namespace

// Reads only: several threads may look at pairs.
CloudDispatcher::Gathered CloudDispatcher::look(const btBroadphasePair& pair) {
  const btCollisionObject &a = objectOf(*pair.m_pProxy0), &b = objectOf(*pair.m_pProxy1);
  if (isSoft(a) || isSoft(b)) return {Gathered::Soft};
  const bool compound = isCompound(a) || isCompound(b);
  if (!compound && !isCloud(a) && !isCloud(b)) return {};
  if (!needsCollision(&a, &b)) return {};
  if (compound) return {Gathered::Compound};
  if (!pair.m_algorithm) return {Gathered::New};
  auto* const ahead = dynamic_cast<AheadPair*>(pair.m_algorithm);
  return ahead ? Gathered{Gathered::Known, ahead} : Gathered{};
}

// A cloud pair's algorithm is made here as the callback would make it; null for other pairs.
AheadPair* CloudDispatcher::madeFor(btBroadphasePair& pair) {
  if (getNearCallback() != defaultNearCallback) return nullptr;
  const btCollisionObject &a = objectOf(*pair.m_pProxy0), &b = objectOf(*pair.m_pProxy1);
  auto* const maker = m_doubleDispatchContactPoints[a.getCollisionShape()->getShapeType()]
                                                   [b.getCollisionShape()->getShapeType()];
  if (!dynamic_cast<AheadPairFactory*>(maker)) return nullptr;
  const btCollisionObjectWrapper wrapA = wrapped(a), wrapB = wrapped(b);
  pair.m_algorithm = findAlgorithm(&wrapA, &wrapB, nullptr, BT_CONTACT_POINT_ALGORITHMS);
  return dynamic_cast<AheadPair*>(pair.m_algorithm);
}

// Returns whether the walk meets a soft body, which changes velocities on the way.
bool CloudDispatcher::gather(btOverlappingPairCache& pairs, const btDispatcherInfo& info) {
  const int count = pairs.getNumOverlappingPairs();
  btBroadphasePair* const all = pairs.getOverlappingPairArrayPtr();
  gathered_.resize(static_cast<std::size_t>(count));
  lookAhead_->share(count, [&](int i) { gathered_[i] = look(all[i]); });
  bool soft = false;
  for (int i = 0; i < count; ++i) {
    Gathered& found = gathered_[i];
    soft = soft || found.kind == Gathered::Soft;
    if (found.kind == Gathered::None || found.kind == Gathered::Soft) continue;
    const btCollisionObject &a = objectOf(*all[i].m_pProxy0), &b = objectOf(*all[i].m_pProxy1);
    if (found.kind == Gathered::Compound) lookAhead_->addChildren(wrapped(a), wrapped(b), info);
    if (found.kind == Gathered::New) found.pair = madeFor(all[i]);
    if (found.pair) lookAhead_->add(*found.pair, a, b, i);
  }
  return soft;
}

// Bullet's walk, over the pairs that are left.
void CloudDispatcher::walk(btOverlappingPairCache& pairs, const btDispatcherInfo& info) {
  for (const int i : lookAhead_->left(pairs.getNumOverlappingPairs()))
    defaultNearCallback(pairs.getOverlappingPairArrayPtr()[i], *this, info);
}

void CloudDispatcher::dispatchAllCollisionPairs(btOverlappingPairCache* pairs,
                                                const btDispatcherInfo& info,
                                                btDispatcher* dispatcher) {
  bool finished = false;
  if ((threads() > 1 || lookAhead_->device()) &&
      info.m_dispatchFunc == btDispatcherInfo::DISPATCH_DISCRETE) {
    // Bullet is not exception-safe; its walk searches the pairs that fail here.
    try {
      lookAhead_->begin();
      const bool soft = gather(*pairs, info);
      finished =
          threads() > 1 && !soft && getNearCallback() == defaultNearCallback && noCallbacks();
      lookAhead_->search(info, finished);
    } catch (...) {
    }
  }
  // Bullet's own cache of pairs walks its array in order, unless it is to sort it first.
  if (finished && !info.m_deterministicOverlappingPairs &&
      typeid(*pairs) == typeid(btHashedOverlappingPairCache))
    walk(*pairs, info);
  else
    btCollisionDispatcher::dispatchAllCollisionPairs(pairs, info, dispatcher);
  lookAhead_->end();
}

}  // namespace cloudcontact
