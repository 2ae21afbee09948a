// CloudContact: the factories, and which of Bullet's shape types they answer for.
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>

#include <cmath>
#include <stdexcept>

#include "cloud_algorithm.h"
#include "narrow_phase.h"
#include "shape_conversion.h"

namespace cloudcontact {

struct CloudContact::Shared {
  explicit Shared(const CloudContactSettings& settings)
      : narrowPhase(settings), factory(narrowPhase) {}

  NarrowPhase narrowPhase;
  CloudAlgorithm::Factory factory;
};

CloudContact::CloudContact(const CloudContactSettings& settings)
    : shared_(std::make_unique<Shared>(settings)) {
  if (!(settings.bears >= 1) || !std::isfinite(settings.bears))
    throw std::invalid_argument("CloudContactSettings: bears must be finite and at least 1");
}

CloudContact::~CloudContact() = default;

void CloudContact::attach(btCollisionDispatcher& dispatcher) {
  constexpr int kCloud = HFFLUID_SHAPE_PROXYTYPE;
  const auto answerFor = [&](int a, int b) {
    dispatcher.registerCollisionCreateFunc(a, b, &shared_->factory);
    dispatcher.registerClosestPointsCreateFunc(a, b, &shared_->factory);
  };
  // Compounds and soft bodies stay with Bullet: a compound's algorithm asks for its children's
  // pairs, which then come here. Triangle meshes and terrains stay too, which means no contact.
  for (int other = 0; other < MAX_BROADPHASE_COLLISION_TYPES; ++other) {
    if (!isConvertible(other)) continue;
    answerFor(kCloud, other);
    answerFor(other, kCloud);
  }
  answerFor(kCloud, kCloud);
}

const CloudContactSettings& CloudContact::settings() const {
  return shared_->narrowPhase.settings();
}

CloudContactStatistics CloudContact::statistics() const {
  return shared_->narrowPhase.statistics();
}

void CloudContact::resetStatistics() {
  shared_->narrowPhase.resetStatistics();
}

}  // namespace cloudcontact
