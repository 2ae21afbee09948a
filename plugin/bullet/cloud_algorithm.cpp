// Bullet's calls, and those ahead of its walk; nothing throws through them.
#include "bullet/cloud_algorithm.h"

#include <cloudcontact/bullet/cloud_dispatcher.h>

#include <exception>
#include <utility>

#include "bullet/pair_state.h"

namespace cloudcontact {

// The element size of Bullet's pool of algorithms, which release builds of Bullet do not check.
static_assert(sizeof(CloudAlgorithm) <= 192);

LookAhead* CloudAlgorithm::lookAheadOf(btDispatcher& dispatcher) {
  const auto* own = dynamic_cast<CloudDispatcher*>(&dispatcher);
  return own ? own->lookAhead_.get() : nullptr;
}

CloudAlgorithm::CloudAlgorithm(const btCollisionAlgorithmConstructionInfo& info,
                               NarrowPhase& narrowPhase)
    : btCollisionAlgorithm(info),
      state_(std::make_unique<PairState>(*info.m_dispatcher1, narrowPhase,
                                         lookAheadOf(*info.m_dispatcher1))) {
  narrowPhase.add(*this);
}

CloudAlgorithm::~CloudAlgorithm() {
  state_->narrowPhase.remove(*this);
  if (state_->lookAhead) state_->lookAhead->forget(*this, state_->slot);
}

CloudAlgorithm::Name CloudAlgorithm::name() const {
  return {state_->summary.a, state_->summary.b, state_->child[0], state_->child[1]};
}

void CloudAlgorithm::save(ByteWriter& writer) const {
  state_->keepIn(writer);
}

const std::vector<btPersistentManifold*>& CloudAlgorithm::restore(ByteReader& reader,
                                                                  std::size_t manifolds) {
  PairState& own = *state_;
  own.keepIn(reader);
  own.moved.drop();
  return own.writer.resize(manifolds, *own.summary.a, *own.summary.b);
}

const CloudContactSettings& CloudAlgorithm::settings() const {
  return state_->narrowPhase.settings();
}

void CloudAlgorithm::processCollision(const btCollisionObjectWrapper* a,
                                      const btCollisionObjectWrapper* b,
                                      const btDispatcherInfo& info, btManifoldResult* result) {
  // Bullet is not exception-safe. A failure is counted and the pair has no contacts, because old
  // ones would keep pushing where the bodies no longer are.
  try {
    state_->process(*this, *a, *b, info, *result);
    return;
  } catch (const std::exception& failure) {
    state_->narrowPhase.countFailure(failure.what());
  } catch (...) {
    state_->narrowPhase.countFailure("unknown failure in the narrow phase");
  }
  state_->writer.clear();
}

std::size_t CloudAlgorithm::prepare(const btCollisionObjectWrapper& a,
                                    const btCollisionObjectWrapper& b,
                                    const btDispatcherInfo& info) noexcept {
  PairState& own = *state_;
  own.searchedStep = own.movedStep = own.readyStep = own.finished.step = 0;
  if (!std::exchange(own.processed, false)) return 0;
  if (own.staysApart(a, b, info.m_timeStep)) return 0;
  try {
    own.openStep();
    // Without lockToRead(): no pair with a soft body is processed yet, and of 10,000 pairs the lock
    // was most of the time.
    own.ahead = own.reader.read(own.narrowPhase.settings(), a, b, info.m_timeStep, true);
    if (own.ahead.wrong || own.ahead.apart) return 0;
    if (isSwept(a, b, info)) return 0;
    own.readyStep = own.lookAhead->step();
    if (own.ahead.byShapes) return 0;
    if (own.isKnown(own.ahead)) {
      own.moved.move(own.ahead.a, own.ahead.b);
      own.movedStep = own.lookAhead->step();
      return 0;
    }
  } catch (...) {
    return 0;  // processCollision() fails likewise and counts it
  }
  return 1 + own.finder.sampleLookups();
}

void CloudAlgorithm::searchAhead(const TaskRunner* shareOut) noexcept {
  PairState& own = *state_;
  const auto start = PairState::Clock::now();
  try {
    own.finder.search(own.ahead.a, own.ahead.b, own.ahead.settings, shareOut);
    own.searchedStep = own.lookAhead->step();
  } catch (...) {  // as above
  }
  own.aheadSeconds = PairState::since(start);
  own.aheadOnDevice = false;
}

SearchTask CloudAlgorithm::deviceTask() noexcept {
  PairState& own = *state_;
  SearchTask task{&own.ahead.a, &own.ahead.b, &own.ahead.settings, &own.finder, &own.deviceRoom};
  task.apart = own.apart;
  return task;
}

void CloudAlgorithm::searchedOnDevice(double seconds) noexcept {
  PairState& own = *state_;
  own.searchedStep = own.lookAhead->step();
  own.aheadSeconds = seconds;
  own.aheadOnDevice = true;
}

bool CloudAlgorithm::finish(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                            const btDispatcherInfo& info) noexcept {
  PairState& own = *state_;
  if (own.readyStep != own.lookAhead->step() || !own.weighed) return false;
  try {
    return own.finish(a, b, info.m_timeStep);
  } catch (...) {
    return false;  // processCollision() tries again
  }
}

void CloudAlgorithm::reserve(int threads) {
  state_->narrowPhase.workspace()->reserve(threads);
}

btScalar CloudAlgorithm::calculateTimeOfImpact(btCollisionObject*, btCollisionObject*,
                                               const btDispatcherInfo&, btManifoldResult*) {
  return 1;
}

void CloudAlgorithm::getAllContactManifolds(btManifoldArray& manifolds) {
  for (btPersistentManifold* manifold : state_->writer.manifolds()) manifolds.push_back(manifold);
}

btCollisionAlgorithm* CloudAlgorithm::Factory::CreateCollisionAlgorithm(
    btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper*,
    const btCollisionObjectWrapper*) {
  void* const memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(CloudAlgorithm));
  return new (memory) CloudAlgorithm(info, narrowPhase_);
}

}  // namespace cloudcontact
