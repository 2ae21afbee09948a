// One pair's step: query, search, and points written to manifolds or to a Bullet query.
#include "bullet/pair_state.h"

#include <cloudcontact/contact/depth_error.h>

#include <algorithm>
#include <typeinfo>

#include "bullet/closest_gap.h"
#include "bullet/convert.h"
#include "bullet/turning.h"

namespace cloudcontact {

namespace {

// [voxels per step] Slower sliding is indistinguishable from the solver's residue at rest.
constexpr double kSlidingVoxelsPerStep = 1e-3;

// Pairs that move by more in a step are also looked up beside their contact. Without,
// `peg_in_hole.sdf` is thrown out of its hole at 120 Hz, and is 0.8 mm deep in it at 240 Hz.
constexpr double kBesideVoxels = 1;

// [voxels] Pairs that touch by less than the first and close by more than the second in a step get
// points for what is about to touch beside what does (ContactFinder::lookAround()). Slower ones
// turn by less than the fits' noise until they are seen again.
constexpr double kLightly = 0.1, kCloses = 0.01;

// [voxels] WriteSettings::together; the fits' noise is 1e-4.
constexpr double kTogether = 0.001;

// Whether bodies that touch lightly close by so much within the step that what has not touched yet
// may touch as well.
bool closesLightly(double step, const PairQuery& query, const ContactResult& found) {
  if (found.samples == 0) return false;
  double deepest = -1e30, closes = 0;
  for (const ContactPoint& point : found.points) {
    const Vec3 meeting = query.a.motion.at(point.position) - query.b.motion.at(point.position);
    deepest = std::max(deepest, point.depth);
    closes = std::max(closes, step * meeting.dot(point.normal));
  }
  return deepest < kLightly * query.voxel && closes > 0.5 * deepest &&
         closes > kCloses * query.voxel;
}

// Whether a patch is broad both ways: points on one place or on a line resist no turn about it.
bool isBroad(const ContactResult& found, double voxel) {
  return std::any_of(found.patches.begin(), found.patches.end(), [&](const Patch& patch) {
    const ContactPoint* const p = found.points.data() + patch.firstPoint;
    return patch.points == 4 &&
           (p[0].position - p[2].position).cross(p[1].position - p[3].position).norm() >
               voxel * voxel;
  });
}

// Whether contacts push both bodies, and all that moves has a velocity that is known.
bool canLeave(const PairSides& sides) {
  const auto can = [](const btCollisionObject& object) {
    return object.hasContactResponse() &&
           (btRigidBody::upcast(&object) || !(inverseMass(object) > 0));
  };
  return can(*sides.wrapA->getCollisionObject()) && can(*sides.wrapB->getCollisionObject());
}

// Several pairs may do so at once.
void keepAwake(NarrowPhase& narrowPhase, const PairSides& sides) {
  const auto lock = narrowPhase.lockToPush();
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

void PairState::keep(const PairQuery& query, const ContactResult& contact, bool swept) {
  if (swept || levels.fades()) return moved.drop();
  const double motion = narrowPhase.settings().reuseMotion;
  if (!(motion > 0) || query.byShapes) return;
  if (!sameMatter(query, asked)) moved.drop();
  asked = query;
  moved.keep(query.a, query.b, query.settings, motion * query.voxel, query.voxel, contact);
}

double PairState::clearAfter(const PairQuery& query, const PairSides& sides,
                             const ContactResult& contact) const {
  const bool clear = contact.samples == 0 && contact.patches.empty() && !query.law.remembering &&
                     !levels.fades() && !hasThreshold(*sides.wrapA) && !hasThreshold(*sides.wrapB);
  return clear ? query.voxel : 0;
}

// Leaves the result in the finder. Returns the time [s] that it took ahead of Bullet's walk.
double PairState::search(const PairQuery& query) {
  const std::uint64_t step = std::exchange(searchedStep, 0);
  const bool known = step > 0 && step == lookAhead->step() && sameQuery(query, ahead);
  if (!known) finder.search(query.a, query.b, query.settings);
  if (known) lookAhead->countTaken();
  onDevice = known && aheadOnDevice;
  return known ? aheadSeconds : 0;
}

// Curved surfaces meet as they did without.
void PairState::lookAround(const PairQuery& query) {
  finder.lookAround(query.a, query.b, query.settings);
  if (!isBroad(finder.latest(), query.voxel)) finder.search(query.a, query.b, query.settings);
}

// Bodies that touched in the last step have met its forces already: what rests costs nothing here.
void PairState::lookBeside(const PairQuery& query, double step) {
  ContactBody a = query.a, b = query.b;
  if (!touched) {
    a.motion.linear += step * query.pull[0];
    b.motion.linear += step * query.pull[1];
  }
  const double moves = step * closingSpeed(a, b);
  if (moves <= kBesideVoxels * query.voxel) return;
  ContactSettings settings = query.settings;
  settings.margin = std::max(settings.margin, moves);
  finder.lookBeside(a, b, settings, step);
}

std::optional<Touch> PairState::lookOn(PairQuery& query, double step) {
  ContactBody a = query.a, b = query.b;
  const Touch end = endOf(step, a, b);
  finder.search(a, b, query.settings);
  if (finder.latest().samples == 0) {
    finder.search(query.a, query.b, query.settings);
    return std::nullopt;
  }
  query.a = a;
  query.b = b;
  return end;
}

// By shapes if the query asks for it and the bodies are not too deep in each other.
const ContactResult& PairState::find(PairQuery& query, const btCollisionObjectWrapper& a,
                                     const btCollisionObjectWrapper& b, double step, bool swept,
                                     double& earlier) {
  onDevice = false;
  answeredByShapes = query.byShapes && shapes.search(asShape(query.a, query.recognized[0]),
                                                     asShape(query.b, query.recognized[1]),
                                                     query.settings, query.voxel);
  if (answeredByShapes) return shapes.withIds();
  if (query.byShapes) reader.chooseLevels(narrowPhase.settings(), a, b, query);
  earlier = search(query);
  if (query.levels.tolerance > 0)
    levels.settle({narrowPhase.settings(), a, b, reader, finder}, query, step);
  if (step > 0 && !swept && turnsWithin(step, query, finder.latest(), a, b))
    turned = lookOn(query, step);
  if (step > 0 && !swept && !turned && closesLightly(step, query, finder.latest()))
    lookAround(query);
  if (step > 0 && !swept && !turned) lookBeside(query, step);
  if (!(query.levels.tolerance > 0)) return finder.withIds();
  const ContactResult& found = finder.withIds();
  return step > 0 ? levels.faded(found) : found;
}

void PairState::closeStep(const PairQuery& query, const PairSides& sides, Answer how) {
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

bool PairState::write(const PairQuery& query, const PairSides& sides, const ContactResult& contact,
                      double step) {
  const PairLaw& law = query.law;
  WriteSettings how;
  how.rigid = std::holds_alternative<Rigid>(law.shared);
  how.step = step;
  how.automatic = law.automatic;
  how.together = kTogether * query.voxel;
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

std::optional<Touch> PairState::sweepOn(const btCollisionObjectWrapper& a,
                                        const btCollisionObjectWrapper& b,
                                        const btDispatcherInfo& info, PairQuery& query) {
  std::optional<Touch> touch;
  {
    const auto lock = narrowPhase.lockToRead();
    if (!isSwept(a, b, info)) return std::nullopt;
    if (!sweep) sweep = std::make_unique<PairSweep>(narrowPhase.workspace(), narrowPhase.reading());
    if (query.byShapes) reader.chooseLevels(narrowPhase.settings(), a, b, query);
    touch = sweep->find(query, a, b, double(info.m_timeStep));
  }
  if (touch) query = read(a, b, info.m_timeStep, true, 0, &*touch);
  return touch;
}

void PairState::count(const PairQuery& query, const PairSides& sides, const Answered& found,
                      double seconds) {
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
  summary.work = finder.work();
  summary.bytes = bytesKept();
  summary.coarser += used.coarser;
  summary.eased += used.eased;
  summary.refined += used.refined;
  const ContactBody* const bodies[2] = {&query.a, &query.b};
  for (int side = 0; side < 2; ++side) {
    summary.voxelLevel[side] = query.levels.level[side];
    summary.voxel[side] = bodies[side]->field ? bodies[side]->field->cloud().voxelSize() : 0;
  }
  if (how != Answer::Searched) return;
  for (const ContactBody* body : {&query.a, &query.b})
    if (body->field) summary.samples += body->field->sampleCount();
}

PairState::Answered PairState::answer(PairQuery& query, const btCollisionObjectWrapper& a,
                                      const btCollisionObjectWrapper& b, double step, bool swept) {
  const bool steps = step > 0;
  double earlier = 0;
  const bool movedAhead = steps && !swept && isMoved(query);
  const bool reused = movedAhead || (steps && !swept && isKnown(query));
  turned.reset();
  const ContactResult& contact = movedAhead ? moved.latest()
                                 : reused   ? moved.move(query.a, query.b)
                                            : find(query, a, b, step, swept, earlier);
  if (reused) moved.age();
  if (steps && !reused) {
    apart = query.a.field && query.b.field && contact.samples == 0;
    touched = contact.samples > 0;
    keep(query, contact, swept || turned);
  }
  return {&contact, reused ? Answer::Moved : answeredBy(), earlier};
}

// All of the pair's step that other pairs do not feel. A new manifold is left to the walk, since
// their order is the solver's.
bool PairState::finish(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                       double step) {
  const auto start = Clock::now();
  finished.found = answer(ahead, a, b, knownStep(step), false);
  finished.written = finished.leaves = false;
  processed = true;
  PairSides sides{&a, &b, ahead.a.motion, ahead.b.motion, ahead.mass};
  if (turned) sides.touch = &*turned;
  const std::size_t patches = finished.found.contact->patches.size();
  if (std::max<std::size_t>(patches, 1) <= writer.manifolds().size()) {
    finished.leaves = write(ahead, sides, *finished.found.contact, step);
    finished.written = true;
  }
  finished.seconds = finished.found.earlier + since(start);
  count(ahead, sides, finished.found, finished.seconds);
  closeStep(ahead, sides, finished.found.how);
  clearVoxel = clearAfter(ahead, sides, *finished.found.contact);
  const bool done = finished.written && !finished.leaves;
  finished.step = done ? 0 : lookAhead->step();
  return done;
}

// What is left of a step that finish() began. False: it did not.
bool PairState::takeFinished(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                             double step) {
  const std::uint64_t made = std::exchange(finished.step, 0);
  if (made == 0 || !lookAhead || made != lookAhead->step()) return false;
  PairSides sides{&a, &b, ahead.a.motion, ahead.b.motion, ahead.mass};
  if (turned) sides.touch = &*turned;
  const ContactResult& contact = *finished.found.contact;
  if (!finished.written) finished.leaves = write(ahead, sides, contact, step);
  if (finished.leaves) keepAwake(narrowPhase, sides);
  return true;
}

void PairState::process(AheadPair& self, const btCollisionObjectWrapper& a,
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
  if (steps && staysApart(a, b, info.m_timeStep)) return;
  if (steps) openStep(), clearVoxel = 0;
  PairQuery query = read(a, b, info.m_timeStep, steps, steps ? 0 : gapOf(result));
  if (query.wrong) narrowPhase.countFailure(query.wrong);
  std::optional<Touch> touch;
  if (steps && !query.wrong) touch = sweepOn(a, b, info, query);
  if (steps && (query.wrong || query.apart)) leaving.reset();
  if (query.wrong || query.apart) return writer.clear();
  const Answered found =
      answer(query, a, b, steps ? knownStep(info.m_timeStep) : 0, touch.has_value());
  PairSides sides{&a, &b, query.a.motion, query.b.motion, query.mass};
  if (touch || turned) sides.touch = touch ? &*touch : &*turned;
  if (!steps)
    report(result, sides, query.a, query.b, *found.contact);
  else if (write(query, sides, *found.contact, info.m_timeStep))
    keepAwake(narrowPhase, sides);
  count(query, sides, found, found.earlier + since(start));
  if (!steps) return;
  closeStep(query, sides, found.how);
  if (!touch) clearVoxel = clearAfter(query, sides, *found.contact);
}

}  // namespace cloudcontact
