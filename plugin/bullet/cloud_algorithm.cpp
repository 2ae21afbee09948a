// One pair's step: wrappers to ContactBody, ContactFinder, points to manifolds or to a query.
#include "bullet/cloud_algorithm.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <cloudcontact/bullet/cloud_dispatcher.h>

#include <chrono>
#include <cstdint>
#include <exception>
#include <typeinfo>
#include <utility>

#include "bullet/closest_gap.h"
#include "bullet/convert.h"
#include "bullet/look_ahead.h"
#include "bullet/manifold_writer.h"
#include "bullet/narrow_phase.h"
#include "bullet/pair_memory.h"
#include "bullet/pair_query.h"

namespace cloudcontact {

namespace {

// The collision algorithm pool's element; release builds of Bullet do not check it.
static_assert(sizeof(CloudAlgorithm) <= 192);

// [voxels a step] Sliding slower than this is not told from a standing contact's solver residue.
constexpr double kSlidingVoxelsPerStep = 1e-3;

using Clock = std::chrono::steady_clock;

double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// A query wants the points, or, where the bodies are apart, how far: its own addContactPoint also
// wants a manifold, of which it reads the order of the bodies.
void tell(btManifoldResult& result, const PairSides& sides, const ContactBody& a,
          const ContactBody& b, const ContactResult& contact) {
  btPersistentManifold order(sides.wrapA->getCollisionObject(), sides.wrapB->getCollisionObject(),
                             0, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
  btPersistentManifold* const before = result.getPersistentManifold();
  const auto add = [&result](const ContactPoint& point) {
    const Vec3 onB = point.position - point.depth / 2 * point.normal;
    result.addContactPoint(toBullet(Vec3(-point.normal)), toBullet(onB),
                           static_cast<btScalar>(-point.depth));
  };
  result.setPersistentManifold(&order);
  for (const ContactPoint& point : contact.points) add(point);
  if (contact.points.empty() && result.m_closestPointDistanceThreshold > 0)
    if (const auto gap = closestGap(a, b, result.m_closestPointDistanceThreshold)) add(*gap);
  result.setPersistentManifold(before);
}

}  // namespace

struct CloudAlgorithm::State {
  State(btDispatcher& dispatcher, NarrowPhase& shared) : narrowPhase(shared), writer(dispatcher) {
    if (const auto* own = dynamic_cast<CloudDispatcher*>(&dispatcher))
      lookAhead = own->lookAhead_.get();
  }

  void process(CloudAlgorithm& self, const btCollisionObjectWrapper& a,
               const btCollisionObjectWrapper& b, const btDispatcherInfo& info,
               btManifoldResult& result);
  PairQuery read(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b, double step,
                 bool steps) {
    const auto lock = narrowPhase.whileReading();
    return reader.read(narrowPhase.settings(), a, b, step, steps);
  }
  double answer(const PairQuery& query);
  void write(const PairQuery& query, const PairSides& sides, const ContactResult& contact,
             double step);

  NarrowPhase& narrowPhase;
  LookAhead* lookAhead = nullptr;  // where the dispatcher has one
  ManifoldWriter writer;
  PairReader reader;
  ContactFinder finder;  // a pair's own: it remembers the last step's patches, to name them again
  PairMemory memory;     // of a viscoelastic law

  PairQuery ahead;                 // what is worked out ahead
  double aheadSeconds = 0;         // and took so long
  std::uint64_t answeredStep = 0;  // the finder has searched for it in this step; 0: it has not
  bool wanted = true;              // processCollision() came after the last look ahead
  int slot = -1;                   // as a compound's child
};

// Leaves the answer in the finder; [s] that it took ahead of this step.
double CloudAlgorithm::State::answer(const PairQuery& query) {
  const std::uint64_t step = std::exchange(answeredStep, 0);
  const bool known = step > 0 && step == lookAhead->step() && sameQuestion(query, ahead);
  if (!known) finder.search(query.a, query.b, query.settings);
  if (known) lookAhead->countTaken();
  return known ? aheadSeconds : 0;
}

void CloudAlgorithm::State::write(const PairQuery& query, const PairSides& sides,
                                  const ContactResult& contact, double step) {
  const PairLaw& law = query.law;
  WriteSettings how{std::holds_alternative<Rigid>(law.shared), 0, step, law.automatic, {}};
  if (step > 0) how.slidingSpeed = kSlidingVoxelsPerStep * query.voxel / step;
  if (law.remembering)
    how.shared = memory.row(*law.remembering, sides, contact, writer.manifolds(), knownStep(step));
  writer.write(sides, contact, how);
  if (law.remembering) memory.remember(sides, writer.manifolds());
}

void CloudAlgorithm::State::process(CloudAlgorithm& self, const btCollisionObjectWrapper& a,
                                    const btCollisionObjectWrapper& b, const btDispatcherInfo& info,
                                    btManifoldResult& result) {
  const auto start = Clock::now();
  wanted = true;
  // Bullet's queries subclass the result to override addContactPoint; its solver never does.
  const bool steps = typeid(result) == typeid(btManifoldResult);
  if (steps && lookAhead && lookAhead->step() > 0 && (a.m_parent || b.m_parent))
    lookAhead->remember(self, a, b, slot);
  const PairQuery query = read(a, b, info.m_timeStep, steps);
  if (query.wrong) {
    narrowPhase.countFailure(query.wrong);
    writer.clear();
    return;
  }
  const double earlier = answer(query);
  const ContactResult& contact = finder.named();
  const PairSides sides{&a, &b, query.a.motion, query.b.motion, query.mass};
  if (steps)
    write(query, sides, contact, info.m_timeStep);
  else
    tell(result, sides, query.a, query.b, contact);
  narrowPhase.count(earlier + since(start), contact.samples, contact.points.size());
}

CloudAlgorithm::CloudAlgorithm(const btCollisionAlgorithmConstructionInfo& info,
                               NarrowPhase& narrowPhase)
    : btCollisionAlgorithm(info),
      state_(std::make_unique<State>(*info.m_dispatcher1, narrowPhase)) {}

CloudAlgorithm::~CloudAlgorithm() {
  if (state_->lookAhead) state_->lookAhead->forget(*this, state_->slot);
}

void CloudAlgorithm::processCollision(const btCollisionObjectWrapper* a,
                                      const btCollisionObjectWrapper* b,
                                      const btDispatcherInfo& info, btManifoldResult* result) {
  // Bullet is not exception-safe: what goes wrong is counted, and the pair has no contacts, for old
  // ones would go on pressing where the bodies no longer are.
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
  State& own = *state_;
  own.answeredStep = 0;
  if (!std::exchange(own.wanted, false)) return 0;
  try {
    own.ahead = own.read(a, b, info.m_timeStep, true);
  } catch (...) {
    return 0;  // processCollision() will meet it too, and tell
  }
  if (own.ahead.wrong) return 0;
  return 1 + own.finder.asked();
}

void CloudAlgorithm::workOut(const TaskRunner* shareOut) noexcept {
  State& own = *state_;
  const auto start = Clock::now();
  try {
    own.finder.search(own.ahead.a, own.ahead.b, own.ahead.settings, shareOut);
    own.answeredStep = own.lookAhead->step();
  } catch (...) {  // as above
  }
  own.aheadSeconds = since(start);
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
