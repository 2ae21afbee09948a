// Bullet's calls, and those ahead of its walk; nothing throws through them.
#include "bullet/cloud_algorithm.h"

#include <cloudcontact/bullet/cloud_dispatcher.h>

#include <exception>

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
  try {
    return state_->prepare(a, b, info);
  } catch (...) {
    return 0;  // processCollision() fails likewise and counts it
  }
}

void CloudAlgorithm::searchAhead(const TaskRunner* shareOut) noexcept {
  PairState& own = *state_;
  const auto start = PairState::Clock::now();
  try {
    const PairQuery& query = own.now.query;
    own.finder.search(query.a, query.b, query.settings, own.now.contact, shareOut);
    own.searched(PairState::since(start), Answer::Searched);
  } catch (...) {  // as above
  }
}

SearchTask CloudAlgorithm::deviceTask() noexcept {
  PairState& own = *state_;
  const PairQuery& query = own.now.query;
  SearchTask task{&query.a,    &query.b,         &query.settings,
                  &own.finder, &own.now.contact, &own.deviceRoom};
  task.apart = own.apart;
  return task;
}

void CloudAlgorithm::searchedOnDevice(double seconds) noexcept {
  state_->searched(seconds, Answer::Device);
}

bool CloudAlgorithm::finish(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                            const btDispatcherInfo&) noexcept {
  PairState& own = *state_;
  if (own.stage() == PairState::Stage::None || !own.weighed) return false;
  try {
    return own.finish(a, b);
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
