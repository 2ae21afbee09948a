// The algorithm factories, and the shape types that they are registered for.
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <cloudcontact/bullet/cloud_contact.h>
#include <cloudcontact/bullet/cloud_shape.h>

#include <cmath>
#include <stdexcept>

#include "bullet/cloud_algorithm.h"
#include "bullet/narrow_phase.h"
#include "bullet/pair_law.h"
#include "bullet/soft_algorithm.h"
#include "bullet/world_bytes.h"

namespace cloudcontact {

namespace {

void validate(const CloudContactSettings& settings) {
  if (settings.law && !takesBodiesSprings(*settings.law)) cloudcontact::validate(*settings.law);
  if (settings.samples == 0)
    throw std::invalid_argument("CloudContactSettings: samples must be 1 at least");
  if (!(settings.bears >= 1) || !std::isfinite(settings.bears))
    throw std::invalid_argument("CloudContactSettings: bears must be finite and at least 1");
  const Fidelity& fidelity = settings.fidelity;
  if (!(fidelity.tolerance >= 0) || !std::isfinite(fidelity.tolerance))
    throw std::invalid_argument(
        "CloudContactSettings: fidelity.tolerance must be finite and not negative [m]");
  if (!(fidelity.budget >= 0))
    throw std::invalid_argument(
        "CloudContactSettings: fidelity.budget must not be negative [s per step]; 0 is no limit");
  if (fidelity.exact && fidelity.tolerance > 0)
    throw std::invalid_argument("CloudContactSettings: a fidelity that is exact has no tolerance");
  if (!(settings.leavingSpeed > 0))
    throw std::invalid_argument(
        "CloudContactSettings: leavingSpeed must be positive; infinity leaves it to the spring");
  if (!(settings.reuseMotion >= 0) || !std::isfinite(settings.reuseMotion))
    throw std::invalid_argument(
        "CloudContactSettings: reuseMotion must be finite and not negative; 0 searches every step");
}

}  // namespace

struct CloudContact::State {
  explicit State(const CloudContactSettings& settings)
      : narrowPhase(settings), factory(narrowPhase), softFactory(narrowPhase) {}

  NarrowPhase narrowPhase;
  CloudAlgorithm::Factory factory;
  SoftAlgorithm::Factory softFactory;
};

CloudContact::CloudContact(const CloudContactSettings& settings)
    : state_(std::make_unique<State>(settings)) {
  validate(settings);
}

CloudContact::~CloudContact() = default;

void CloudContact::attach(btCollisionDispatcher& dispatcher) {
  constexpr int kCloud = CloudShape::kCloudType;
  const auto registerFor = [&](int a, int b) {
    dispatcher.registerCollisionCreateFunc(a, b, &state_->factory);
    dispatcher.registerClosestPointsCreateFunc(a, b, &state_->factory);
  };
  // Bullet's algorithm for compounds creates its children's pairs through these factories. A pair
  // that has no answer is counted as a failure.
  for (int other = 0; other < MAX_BROADPHASE_COLLISION_TYPES; ++other) {
    if (other == COMPOUND_SHAPE_PROXYTYPE || other == SOFTBODY_SHAPE_PROXYTYPE) continue;
    registerFor(kCloud, other);
    registerFor(other, kCloud);
  }
  dispatcher.registerCollisionCreateFunc(kCloud, SOFTBODY_SHAPE_PROXYTYPE, &state_->softFactory);
  dispatcher.registerCollisionCreateFunc(SOFTBODY_SHAPE_PROXYTYPE, kCloud, &state_->softFactory);
}

const NarrowPhase& ContactRecords::narrowPhaseOf(const CloudContact& contact) {
  return contact.state_->narrowPhase;
}

const CloudContactSettings& CloudContact::settings() const {
  return state_->narrowPhase.settings();
}

CloudContactStatistics CloudContact::statistics() const {
  return state_->narrowPhase.statistics();
}

std::vector<PairReport> CloudContact::pairs() const {
  return state_->narrowPhase.pairs();
}

void CloudContact::softContacts(const btSoftBody& soft,
                                std::vector<SoftContactPoint>& points) const {
  for (const SoftAlgorithm* pair : state_->narrowPhase.softPairs()) pair->append(soft, points);
}

void CloudContact::resetStatistics() {
  state_->narrowPhase.resetStatistics();
}

}  // namespace cloudcontact
