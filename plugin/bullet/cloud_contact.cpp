// CloudContact: the factories, and which of Bullet's shape types they answer for.
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>

#include <cmath>
#include <stdexcept>

#include "bullet/cloud_algorithm.h"
#include "bullet/narrow_phase.h"
#include "bullet/pair_law.h"
#include "bullet/shape_conversion.h"
#include "bullet/soft_algorithm.h"

namespace cloudcontact {

namespace {

const CloudContactSettings& checked(const CloudContactSettings& settings) {
  if (settings.law && !takesBodiesSprings(*settings.law)) validate(*settings.law);
  return settings;
}

}  // namespace

struct CloudContact::Shared {
  explicit Shared(const CloudContactSettings& settings)
      : narrowPhase(checked(settings)), factory(narrowPhase), softFactory(narrowPhase) {}

  NarrowPhase narrowPhase;
  CloudAlgorithm::Factory factory;
  SoftAlgorithm::Factory softFactory;
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
  // Compounds stay with Bullet: a compound's algorithm asks for its children's pairs, which then
  // come here. Triangle meshes and terrains stay too, which means no contact.
  for (int other = 0; other < MAX_BROADPHASE_COLLISION_TYPES; ++other) {
    if (!isConvertible(other)) continue;
    answerFor(kCloud, other);
    answerFor(other, kCloud);
  }
  answerFor(kCloud, kCloud);
  dispatcher.registerCollisionCreateFunc(kCloud, SOFTBODY_SHAPE_PROXYTYPE, &shared_->softFactory);
  dispatcher.registerCollisionCreateFunc(SOFTBODY_SHAPE_PROXYTYPE, kCloud, &shared_->softFactory);
}

const CloudContactSettings& CloudContact::settings() const {
  return shared_->narrowPhase.settings();
}

CloudContactStatistics CloudContact::statistics() const {
  return shared_->narrowPhase.statistics();
}

void CloudContact::softContacts(const btSoftBody& soft,
                                std::vector<SoftContactPoint>& points) const {
  for (const SoftAlgorithm* pair : shared_->narrowPhase.softPairs()) pair->tell(soft, points);
}

void CloudContact::resetStatistics() {
  shared_->narrowPhase.resetStatistics();
}

}  // namespace cloudcontact
