// One pair's step: query, search, and points written to manifolds or to a Bullet query.
#include "bullet/cloud_algorithm.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <cloudcontact/bullet/cloud_dispatcher.h>
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/contact/depth_error.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <exception>
#include <typeinfo>
#include <utility>

#include "bullet/closest_gap.h"
#include "bullet/convert.h"
#include "bullet/leaving.h"
#include "bullet/level_switch.h"
#include "bullet/manifold_writer.h"
#include "bullet/narrow_phase.h"
#include "bullet/pair_query.h"
#include "bullet/pair_sweep.h"
#include "contact/moved_contact.h"
#include "contact/shape_contact.h"

namespace cloudcontact {

namespace {

// The element size of Bullet's pool of algorithms, which release builds of Bullet do not check.
static_assert(sizeof(CloudAlgorithm) <= 192);

// [voxels per step] Slower sliding is indistinguishable from the solver's residue at rest.
constexpr double kSlidingVoxelsPerStep = 1e-3;

using Clock = std::chrono::steady_clock;

double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Whether contacts push both bodies, and all that moves has a velocity that is known.
bool canLeave(const PairSides& sides) {
  const auto can = [](const btCollisionObject& object) {
    return object.hasContactResponse() &&
           (btRigidBody::upcast(&object) || !(inverseMass(object) > 0));
  };
  return can(*sides.wrapA->getCollisionObject()) && can(*sides.wrapB->getCollisionObject());
}

void keepAwake(const PairSides& sides) {
  for (const btCollisionObjectWrapper* wrap : {sides.wrapA, sides.wrapB})
    const_cast<btCollisionObject*>(wrap->getCollisionObject())->setDeactivationTime(0);
}

// How far from each other bodies may be that a Bullet query asks for [m]. Not infinite.
double gapOf(const btManifoldResult& result) {
  return std::clamp(double(result.m_closestPointDistanceThreshold), 0.0, 1e9);
}

// Gives a Bullet query the points or, if the bodies are apart, the gap. Its addContactPoint() reads
// the order of the bodies from a manifold.
void report(btManifoldResult& result, const PairSides& sides, const ContactBody& a,
            const ContactBody& b, const ContactResult& contact) {
  btPersistentManifold inOrder(sides.wrapA->getCollisionObject(), sides.wrapB->getCollisionObject(),
                               0, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
  btPersistentManifold* const before = result.getPersistentManifold();
  const auto add = [&result](const ContactPoint& point) {
    const Vec3 onB = point.position - point.depth / 2 * point.normal;
    result.addContactPoint(toBullet(Vec3(-point.normal)), toBullet(onB),
                           static_cast<btScalar>(-point.depth));
  };
  result.setPersistentManifold(&inOrder);
  for (const ContactPoint& point : contact.points) add(point);
  if (contact.points.empty() && result.m_closestPointDistanceThreshold > 0)
    if (const auto gap = closestGap(a, b, result.m_closestPointDistanceThreshold)) add(*gap);
  result.setPersistentManifold(before);
}

}  // namespace

struct CloudAlgorithm::State {
  State(btDispatcher& dispatcher, NarrowPhase& shared)
      : narrowPhase(shared),
        writer(dispatcher),
        reader(shared.reading()),
        finder(shared.workspace()) {
    if (const auto* own = dynamic_cast<CloudDispatcher*>(&dispatcher))
      lookAhead = own->lookAhead_.get();
    narrowPhase.add(summary);
    narrowPhase.budget().add(work);
  }
  ~State() {
    narrowPhase.remove(summary);
    narrowPhase.budget().remove(work);
  }

  template <typename Archive>
  void keepIn(Archive& archive) {
    finder.builder().ids().keepIn(archive);
    shapes.ids().keepIn(archive);
    leaving.keepIn(archive);
    memory.keepIn(archive);
    archive(apart);
  }

  void process(CloudAlgorithm& self, const btCollisionObjectWrapper& a,
               const btCollisionObjectWrapper& b, const btDispatcherInfo& info,
               btManifoldResult& result);
  PairQuery read(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b, double step,
                 bool steps, double gap, const Touch* touch = nullptr) {
    const auto lock = narrowPhase.lockToRead();
    return reader.read(narrowPhase.settings(), a, b, step, steps, gap, touch);
  }
  // Whether the query is now where the pair touches later in the step, and where that is.
  std::optional<Touch> sweepOn(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                               const btDispatcherInfo& info, PairQuery& query);
  double search(const PairQuery& query);
  // Of the last query, if its contact was not moved.
  Answer answeredBy() const {
    return answeredByShapes ? Answer::Shapes : onDevice ? Answer::Device : Answer::Searched;
  }
  // `query`: with finer levels afterwards, if its contact asks for them.
  const ContactResult& find(PairQuery& query, const btCollisionObjectWrapper& a,
                            const btCollisionObjectWrapper& b, double step, double& earlier);
  // The contact of a query, how it came about, and the time [s] that it took ahead of the walk.
  struct Answered {
    const ContactResult* contact = nullptr;
    Answer how = Answer::Searched;
    double earlier = 0;
  };
  // `step` [s]; 0: no step of the world.
  Answered answer(PairQuery& query, const btCollisionObjectWrapper& a,
                  const btCollisionObjectWrapper& b, double step, bool swept);
  // Before a step's query is read, and after its answer; see WorkBudget.
  void openStep() {
    if (!narrowPhase.budget().isLimited()) return;
    narrowPhase.budget().open(work);
    reader.levels().ease = work.ease;
  }
  void closeStep(const PairQuery& query, const PairSides& sides, Answer how);
  // Whether prepare() moved the last contact for this query in this step.
  bool isMoved(const PairQuery& query) {
    const std::uint64_t step = std::exchange(movedStep, 0);
    return step > 0 && step == lookAhead->step() && sameQuery(query, ahead);
  }
  bool isKnown(const PairQuery& query) const {
    return !query.byShapes && sameMatter(query, asked) &&
           moved.holds(query.a, query.b, query.settings.margin);
  }
  void keep(const PairQuery& query, const ContactResult& contact, bool swept);
  void count(const PairQuery& query, const PairSides& sides, const Answered& found, double seconds);
  LevelCount levelsOf(const PairQuery& query, Answer how) const {
    if (how == Answer::Shapes || !(query.levels.tolerance > 0)) return {};
    return {query.levels.level[0] + query.levels.level[1] > 0, query.levels.eased > 0,
            how == Answer::Moved ? 0 : levels.refined()};
  }
  // Returns whether the bodies leave an overlap, and so must not fall asleep.
  bool write(const PairQuery& query, const PairSides& sides, const ContactResult& contact,
             double step);
  bool finish(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b, double step);
  bool takeFinished(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                    double step);

  NarrowPhase& narrowPhase;
  LookAhead* lookAhead = nullptr;  // of a CloudDispatcher, or null
  ManifoldWriter writer;
  PairReader reader;
  ContactFinder finder;  // one per pair: it keeps the last step's patches and their IDs
  ShapeContact shapes;
  Leaving leaving;
  std::unique_ptr<PairSweep> sweep;  // made for the first fast motion
  LevelSwitch levels;
  WorkBudget::Pair work;
  PairMemory memory;
  bool answeredByShapes = false;  // the last query
  PairReport summary;
  PairQuery asked;     // the last query that was searched in a step
  MovedContact moved;  // its contact

  PairQuery ahead;             // the query that is searched ahead
  double aheadSeconds = 0;     // time of that search
  bool aheadOnDevice = false;  // the device made it
  std::uint32_t deviceRoom = SearchTask::kFirstRoom;
  bool onDevice = false;           // it answered the last query
  bool apart = false;              // the last search in a step found no touch of two clouds
  std::uint64_t searchedStep = 0;  // the step in which the finder has searched it; 0: none
  std::uint64_t movedStep = 0;     // the step in which `moved` has answered it; 0: none
  std::uint64_t readyStep = 0;     // the step in which finish() may answer `ahead`; 0: none
  // What finish() made of `ahead`, for the walk.
  struct Finished {
    std::uint64_t step = 0;  // 0: nothing
    Answered found;
    bool written = false, leaves = false;
    double seconds = 0;
  };
  Finished finished;
  bool processed = true;    // processCollision() ran after the last prepare()
  bool weighed = false;     // the bodies' matter was checked
  int slot = -1;            // in CompoundChildren
  int child[2] = {-1, -1};  // of compounds, in the last query
};

void CloudAlgorithm::State::keep(const PairQuery& query, const ContactResult& contact, bool swept) {
  if (swept || levels.fades()) return moved.drop();
  const double motion = narrowPhase.settings().reuseMotion;
  if (!(motion > 0) || query.byShapes) return;
  if (!sameMatter(query, asked)) moved.drop();
  asked = query;
  moved.keep(query.a, query.b, query.settings, motion * query.voxel, query.voxel, contact);
}

// Leaves the result in the finder. Returns the time [s] that it took ahead of Bullet's walk.
double CloudAlgorithm::State::search(const PairQuery& query) {
  const std::uint64_t step = std::exchange(searchedStep, 0);
  const bool known = step > 0 && step == lookAhead->step() && sameQuery(query, ahead);
  if (!known) finder.search(query.a, query.b, query.settings);
  if (known) lookAhead->countTaken();
  onDevice = known && aheadOnDevice;
  return known ? aheadSeconds : 0;
}

// By shapes if the query asks for it and the bodies are not too deep in each other.
const ContactResult& CloudAlgorithm::State::find(PairQuery& query,
                                                 const btCollisionObjectWrapper& a,
                                                 const btCollisionObjectWrapper& b, double step,
                                                 double& earlier) {
  onDevice = false;
  answeredByShapes = query.byShapes && shapes.search(asShape(query.a, query.recognized[0]),
                                                     asShape(query.b, query.recognized[1]),
                                                     query.settings, query.voxel);
  if (answeredByShapes) return shapes.withIds();
  earlier = search(query);
  if (!(query.levels.tolerance > 0)) return finder.withIds();
  levels.settle({narrowPhase.settings(), a, b, reader, finder}, query, step);
  const ContactResult& found = finder.withIds();
  return step > 0 ? levels.faded(found) : found;
}

void CloudAlgorithm::State::closeStep(const PairQuery& query, const PairSides& sides, Answer how) {
  if (!narrowPhase.budget().isLimited()) return;
  int* next = work.name.data();
  for (const btCollisionObjectWrapper* wrap : {sides.wrapA, sides.wrapB}) {
    const btBroadphaseProxy* const proxy = wrap->getCollisionObject()->getBroadphaseHandle();
    *next++ = proxy ? proxy->m_uniqueId : -1;
    *next++ = wrap->m_index;
  }
  const bool searched = how == Answer::Searched || how == Answer::Device;
  work.seconds = Fidelity::kPairSeconds;
  if (searched)
    work.seconds += Fidelity::kLookupSeconds * static_cast<double>(finder.sampleLookups());
  work.harm = query.mass * (query.levels.error + levels.error());
  work.canEase = searched && query.levels.tolerance > 0 && query.levels.eased >= work.ease;
  narrowPhase.budget().close(work);
}

bool CloudAlgorithm::State::write(const PairQuery& query, const PairSides& sides,
                                  const ContactResult& contact, double step) {
  const PairLaw& law = query.law;
  WriteSettings how;
  how.rigid = std::holds_alternative<Rigid>(law.shared);
  how.step = step;
  how.automatic = law.automatic;
  const double most = narrowPhase.settings().leavingSpeed;
  if (sides.touch) leaving.touched(contact);
  if (step > 0 && !sides.touch && canLeave(sides) && leaving.update(query, contact, most, step)) {
    how.automatic.reset();
    how.leavingSpeed = leaving.speed();
    writer.write(sides, leaving.contact(), how);
    return true;
  }
  if (hasThreshold(*sides.wrapA) || hasThreshold(*sides.wrapB)) how.stopsFrom = query.voxel;
  if (step > 0) how.slidingSpeed = kSlidingVoxelsPerStep * query.voxel / step;
  if (law.remembering)
    how.shared = memory.row(*law.remembering, sides, contact, writer.manifolds(), knownStep(step));
  writer.write(sides, contact, how);
  if (law.remembering) memory.remember(sides, writer.manifolds());
  return false;
}

std::optional<Touch> CloudAlgorithm::State::sweepOn(const btCollisionObjectWrapper& a,
                                                    const btCollisionObjectWrapper& b,
                                                    const btDispatcherInfo& info,
                                                    PairQuery& query) {
  std::optional<Touch> touch;
  {
    const auto lock = narrowPhase.lockToRead();
    if (!isSwept(a, b, info)) return std::nullopt;
    if (!sweep) sweep = std::make_unique<PairSweep>(narrowPhase.workspace(), narrowPhase.reading());
    touch = sweep->find(query, a, b, double(info.m_timeStep));
  }
  if (touch) query = read(a, b, info.m_timeStep, true, 0, &*touch);
  return touch;
}

void CloudAlgorithm::State::count(const PairQuery& query, const PairSides& sides,
                                  const Answered& found, double seconds) {
  const ContactResult& contact = *found.contact;
  const Answer how = found.how;
  const LevelCount used = levelsOf(query, how);
  narrowPhase.count(seconds, contact.samples, contact.points.size(), how, used);
  summary.a = sides.wrapA->getCollisionObject();
  summary.b = sides.wrapB->getCollisionObject();
  child[0] = sides.wrapA->m_index;
  child[1] = sides.wrapB->m_index;
  summary.last = how;
  summary.searched += how == Answer::Searched;
  summary.shapes += how == Answer::Shapes;
  summary.moved += how == Answer::Moved;
  summary.device += how == Answer::Device;
  summary.seconds += seconds;
  double error = how == Answer::Shapes ? query.shapeError : depthError(query.a, query.b, contact);
  if (how != Answer::Shapes && !contact.patches.empty())
    error = std::max(error, query.levels.error);
  if (how == Answer::Moved) error += narrowPhase.settings().reuseMotion * query.voxel;
  summary.error = error;
  summary.expectedError = std::max(summary.expectedError, error);
  summary.depth = depthOf(contact);
  summary.level = contact.level;
  summary.tolerance = query.levels.tolerance;
  summary.coarser += used.coarser;
  summary.eased += used.eased;
  summary.refined += used.refined;
  const ContactBody* const bodies[2] = {&query.a, &query.b};
  for (int side = 0; side < 2; ++side) {
    summary.voxelLevel[side] = query.levels.level[side];
    summary.voxel[side] = bodies[side]->field ? bodies[side]->field->cloud().voxelSize() : 0;
  }
  if (how != Answer::Searched) return;
  summary.lookups += finder.sampleLookups();
  for (const ContactBody* body : {&query.a, &query.b})
    if (body->field) summary.samples += body->field->sampleCount();
}

CloudAlgorithm::State::Answered CloudAlgorithm::State::answer(PairQuery& query,
                                                              const btCollisionObjectWrapper& a,
                                                              const btCollisionObjectWrapper& b,
                                                              double step, bool swept) {
  const bool steps = step > 0;
  double earlier = 0;
  const bool movedAhead = steps && !swept && isMoved(query);
  const bool reused = movedAhead || (steps && !swept && isKnown(query));
  const ContactResult& contact = movedAhead ? moved.latest()
                                 : reused   ? moved.move(query.a, query.b)
                                            : find(query, a, b, step, earlier);
  if (reused) moved.age();
  if (steps && !reused) {
    apart = query.a.field && query.b.field && contact.samples == 0;
    keep(query, contact, swept);
  }
  return {&contact, reused ? Answer::Moved : answeredBy(), earlier};
}

// All of the pair's step that other pairs do not feel. A new manifold is left to the walk, since
// their order is the solver's.
bool CloudAlgorithm::State::finish(const btCollisionObjectWrapper& a,
                                   const btCollisionObjectWrapper& b, double step) {
  const auto start = Clock::now();
  finished.found = answer(ahead, a, b, knownStep(step), false);
  finished.written = finished.leaves = false;
  processed = true;
  const PairSides sides{&a, &b, ahead.a.motion, ahead.b.motion, ahead.mass};
  const std::size_t patches = finished.found.contact->patches.size();
  if (std::max<std::size_t>(patches, 1) <= writer.manifolds().size()) {
    finished.leaves = write(ahead, sides, *finished.found.contact, step);
    finished.written = true;
  }
  finished.seconds = finished.found.earlier + since(start);
  count(ahead, sides, finished.found, finished.seconds);
  closeStep(ahead, sides, finished.found.how);
  const bool done = finished.written && !finished.leaves;
  finished.step = done ? 0 : lookAhead->step();
  return done;
}

// What is left of a step that finish() began. False: it did not.
bool CloudAlgorithm::State::takeFinished(const btCollisionObjectWrapper& a,
                                         const btCollisionObjectWrapper& b, double step) {
  const std::uint64_t made = std::exchange(finished.step, 0);
  if (made == 0 || !lookAhead || made != lookAhead->step()) return false;
  const PairSides sides{&a, &b, ahead.a.motion, ahead.b.motion, ahead.mass};
  const ContactResult& contact = *finished.found.contact;
  if (!finished.written) finished.leaves = write(ahead, sides, contact, step);
  if (finished.leaves) keepAwake(sides);
  return true;
}

void CloudAlgorithm::State::process(CloudAlgorithm& self, const btCollisionObjectWrapper& a,
                                    const btCollisionObjectWrapper& b, const btDispatcherInfo& info,
                                    btManifoldResult& result) {
  if (!std::exchange(weighed, true))
    for (const btCollisionObjectWrapper* wrap : {&a, &b})
      narrowPhase.checkMatter(*wrap->getCollisionObject());
  const auto start = Clock::now();
  processed = true;
  // Bullet's queries derive from btManifoldResult; its solver does not.
  const bool steps = typeid(result) == typeid(btManifoldResult);
  if (steps && lookAhead && lookAhead->step() > 0 && (a.m_parent || b.m_parent))
    lookAhead->remember(self, a, b, slot);
  if (steps && takeFinished(a, b, info.m_timeStep)) return;
  if (steps) openStep();
  PairQuery query = read(a, b, info.m_timeStep, steps, steps ? 0 : gapOf(result));
  if (query.wrong) narrowPhase.countFailure(query.wrong);
  std::optional<Touch> touch;
  if (steps && !query.wrong) touch = sweepOn(a, b, info, query);
  if (steps && (query.wrong || query.apart)) leaving.reset();
  if (query.wrong || query.apart) return writer.clear();
  const Answered found =
      answer(query, a, b, steps ? knownStep(info.m_timeStep) : 0, touch.has_value());
  PairSides sides{&a, &b, query.a.motion, query.b.motion, query.mass};
  if (touch) sides.touch = &*touch;
  if (!steps)
    report(result, sides, query.a, query.b, *found.contact);
  else if (write(query, sides, *found.contact, info.m_timeStep))
    keepAwake(sides);
  count(query, sides, found, found.earlier + since(start));
  if (steps) closeStep(query, sides, found.how);
}

CloudAlgorithm::CloudAlgorithm(const btCollisionAlgorithmConstructionInfo& info,
                               NarrowPhase& narrowPhase)
    : btCollisionAlgorithm(info),
      state_(std::make_unique<State>(*info.m_dispatcher1, narrowPhase)) {
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
  State& own = *state_;
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
  State& own = *state_;
  own.searchedStep = own.movedStep = own.readyStep = own.finished.step = 0;
  if (!std::exchange(own.processed, false)) return 0;
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
  State& own = *state_;
  const auto start = Clock::now();
  try {
    own.finder.search(own.ahead.a, own.ahead.b, own.ahead.settings, shareOut);
    own.searchedStep = own.lookAhead->step();
  } catch (...) {  // as above
  }
  own.aheadSeconds = since(start);
  own.aheadOnDevice = false;
}

SearchTask CloudAlgorithm::deviceTask() noexcept {
  State& own = *state_;
  SearchTask task{&own.ahead.a, &own.ahead.b, &own.ahead.settings, &own.finder, &own.deviceRoom};
  task.apart = own.apart;
  return task;
}

void CloudAlgorithm::searchedOnDevice(double seconds) noexcept {
  State& own = *state_;
  own.searchedStep = own.lookAhead->step();
  own.aheadSeconds = seconds;
  own.aheadOnDevice = true;
}

bool CloudAlgorithm::finish(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                            const btDispatcherInfo& info) noexcept {
  State& own = *state_;
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
