// One pair's step: query, search, and points written to manifolds or to a Bullet query.
#include "bullet/pair_state.h"

#include <cloudcontact/contact/depth_error.h>

#include <algorithm>
#include <typeinfo>
#include <utility>

#include "bullet/closest_gap.h"
#include "bullet/support.h"
#include "bullet/turning.h"
#include "contact/pair_frame.h"
#include "contact/shape_contact.h"

namespace cloudcontact {

namespace {

// Pairs that move by more in a step are also looked up beside their contact. Without,
// `peg_in_hole.sdf` is thrown out of its hole at 120 Hz, and is 0.8 mm deep in it at 240 Hz.
constexpr double kBesideVoxels = 1;
// [voxels] To which places of support are known; and what is nearer than that bears weight as soon
// as other support goes.
constexpr double kSupportVoxels = 0.1;
// [voxels per step] What touches and moves by less rests: the fits' noise moves it by as much.
constexpr double kRestsVoxels = 0.01;

// [voxels] WriteSettings::together; the fits' noise is 1e-4.
constexpr double kTogether = 0.001;
// [voxels] WriteSettings::sinks; a gap is known to about that (near_misses.h).
constexpr double kSinks = 0.05;

// Whether the bodies hardly move against each other.
bool stands(const PairStep& step) {
  const PairQuery& query = step.query;
  return step.ahead() * closingSpeed(query.a, query.b) <= kRestsVoxels * query.voxel;
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

}  // namespace

void PairState::keep(const PairStep& step) {
  const PairQuery& query = step.query;
  if (step.touch || levels.fades()) return moved.drop();
  const double motion = narrowPhase.settings().reuseMotion;
  if (!(motion > 0) || query.byShapes) return;
  if (!sameMatter(query, asked)) moved.drop();
  asked = query;
  moved.keep(query.a, query.b, query.settings, motion * query.voxel, query.voxel, step.contact);
  // What may ask for finer voxels is searched again.
  if (query.levels.isCoarse() && levels.error() + moved.error(query.voxel) > query.levels.tolerance)
    moved.drop();
}

bool PairState::clearAfter(const PairStep& step) const {
  return !step.touch && step.contact.samples == 0 && step.contact.patches.empty() &&
         !step.query.law.remembering && !levels.fades();
}

// What has lost a side of its support, as a table of which one foot is lifted by a micrometer,
// would fall about the others for the whole step: it goes on to stand on what is near. What moves
// is looked up around and beside its touches anyway.
void PairState::keepSupport(PairStep& step) {
  const PairQuery& query = step.query;
  if (!touched || !held || !stands(step)) return;
  if (!holdsWeight(query, step.contact, 0, kSupportVoxels * query.voxel))
    finder.lookApart(query.a, query.b, query.settings, step.contact);
}

// Bodies that touched in the last step have met their forces already: what rests costs nothing
// here. But what touches on one side of its center falls about that side, and what rocks is in the
// air.
void PairState::lookBeside(PairStep& step) {
  const PairQuery& query = step.query;
  ContactBody a = query.a, b = query.b;
  const bool rests = touched && (stands(step) || holdsWeight(query, step.contact, 0, 0));
  if (!rests) {
    a.motion.linear += step.ahead() * query.pull[0];
    b.motion.linear += step.ahead() * query.pull[1];
  }
  const double moves = step.ahead() * closingSpeed(a, b);
  if (moves <= kBesideVoxels * query.voxel) return;
  ContactSettings settings = query.settings;
  settings.margin = std::max(settings.margin, moves);
  finder.lookBeside(a, b, settings, step.ahead(), step.contact);
}

// What turns within the step is looked up at its end, if it touches there.
bool PairState::lookAtEnd(PairStep& step, const btCollisionObjectWrapper& a,
                          const btCollisionObjectWrapper& b) {
  PairQuery& query = step.query;
  if (!step.touches() || !turnsWithin(step.ahead(), query, step.contact, a, b)) return false;
  step.turn = turnOn(step.ahead(), query, step.touch);
  if (step.how != Answer::Shapes) {
    if (finder.searchTouch(query.a, query.b, query.settings, step.contact)) return true;
  } else if (ContactResult end; findByShapes(query, false, end) && depthOf(end) > 0) {
    step.contact = std::move(end);
    return true;
  }
  turnBack(*step.turn, query, step.touch);
  step.turn.reset();
  return false;
}

// What is near, or comes near within the step, beside what touches.
void PairState::lookFurther(PairStep& step, const btCollisionObjectWrapper& a,
                            const btCollisionObjectWrapper& b) {
  PairQuery& query = step.query;
  if (lookAtEnd(step, a, b)) return;
  const bool byShapes = step.how == Answer::Shapes;
  // The contact of the last step already bears the weight. A new one does not, so gravity counts.
  Vec3 gains = Vec3::Zero();
  if (byShapes && !touched) gains = step.ahead() * (query.pull[0] - query.pull[1]);
  const bool lightly = step.touches() && closesLightly(step.ahead(), gains, query, step.contact);
  if (byShapes) {
    ContactResult whole;
    if (lightly && findByShapes(query, true, whole)) step.contact = std::move(whole);
    return;
  }
  if (lightly)
    finder.lookAround(query.a, query.b, query.settings, query.voxel * query.voxel, step.contact);
  keepSupport(step);
  lookBeside(step);
}

// What turned within the last step, and goes on so, is looked up at this one's end to begin with.
void PairState::aim(PairStep& step, const btCollisionObjectWrapper& a,
                    const btCollisionObjectWrapper& b) {
  const PairQuery& query = step.query;
  step.turn.reset();
  if (turned && !step.touch && !query.wrong && goesOnTurning(step.ahead(), query, turns, a, b))
    step.turn = turnOn(step.ahead(), step.query, step.touch);
}

// What was aimed at the step's end and touches nothing there is searched where it is.
void PairState::find(PairStep& step, const btCollisionObjectWrapper& a,
                     const btCollisionObjectWrapper& b, bool known) {
  PairQuery& query = step.query;
  if (known)
    lookAhead->countTaken();
  else
    search(step, a, b);
  if (!step.turn || step.touches()) return;
  turnBack(*step.turn, query, step.touch);
  step.turn.reset();
  search(step, a, b);
}

// The last contact, moved; or by shapes, if the query asks for it and the bodies are not too deep
// in each other; or searched, with finer levels if the contact asks for them.
void PairState::search(PairStep& step, const btCollisionObjectWrapper& a,
                       const btCollisionObjectWrapper& b) {
  PairQuery& query = step.query;
  step.how = Answer::Searched;
  step.earlier = 0;
  if (step.isStep && !step.touch && isKnown(query)) {
    step.how = Answer::Moved;
    moved.age(query.a, query.b);
    return moved.move(query.a, query.b, step.contact);
  }
  if (query.byShapes) {
    if (findByShapes(query, false, step.contact)) {
      step.how = Answer::Shapes;
      return;
    }
    reader.chooseLevels(narrowPhase.settings(), a, b, query);
  }
  finder.search(query.a, query.b, query.settings, step.contact);
}

bool PairState::findByShapes(const PairQuery& query, bool lightly, ContactResult& found) const {
  const ContactBody a = asShape(query.a, query.recognized[0]),
                    b = asShape(query.b, query.recognized[1]);
  ContactSettings settings = query.settings;
  settings.margin = marginOf(a, b, query.voxel, settings.margin);  // as clouds would see it
  return findShapes(a, b, settings, query.voxel, found, lightly);
}

void PairState::adjust(PairStep& step, const btCollisionObjectWrapper& a,
                       const btCollisionObjectWrapper& b) {
  if (step.isStep && std::exchange(restored, false)) asked = step.query;
  if (step.how == Answer::Moved) return;
  const bool byShapes = step.how == Answer::Shapes;
  const bool hasLevels = !byShapes && step.query.levels.tolerance > 0;
  if (hasLevels)
    levels.settle({narrowPhase.settings(), a, b, reader, finder}, step.query, step.ahead(),
                  step.contact);
  if (step.isStep && !step.touch) lookFurther(step, a, b);
  if (byShapes)
    giveIds(asShape(step.query.a, step.query.recognized[0]), step.query.voxel, shapeIds,
            step.contact);
  else
    finder.giveIds(step.contact);
  if (hasLevels && step.isStep) levels.fade(step.contact);
  if (!step.isStep) return;
  touched = step.touches();
  apart = step.query.a.field && step.query.b.field && !touched;
  const double place = kSupportVoxels * step.query.voxel;
  held = holdsWeight(step.query, step.contact, -place, -place);
  turned = step.turn.has_value();
  if (turned) turns = turningPlace(step.ahead(), step.query, step.contact);
  keep(step);
}

void PairState::closeStep(const PairStep& step, const PairSides& sides) {
  if (!narrowPhase.budget().isLimited()) return;
  int* next = work.name.data();
  for (const btCollisionObjectWrapper* wrap : {sides.wrapA, sides.wrapB}) {
    const btBroadphaseProxy* const proxy = wrap->getCollisionObject()->getBroadphaseHandle();
    *next++ = proxy ? proxy->m_uniqueId : -1;
    *next++ = wrap->m_index;
  }
  const bool searched = step.how == Answer::Searched || step.how == Answer::Device;
  work.seconds = Fidelity::kPairSeconds;
  if (searched)
    work.seconds += Fidelity::kLookupSeconds * static_cast<double>(finder.sampleLookups());
  work.harm = step.query.mass * (step.query.levels.error + levels.error());
  work.canEase =
      searched && step.query.levels.tolerance > 0 && step.query.levels.eased >= work.ease;
  narrowPhase.budget().close(work);
}

void PairState::write(PairStep& step, const PairSides& sides) {
  const PairQuery& query = step.query;
  const ContactResult& contact = step.contact;
  const PairLaw& law = query.law;
  WriteSettings how;
  how.rigid = std::holds_alternative<Rigid>(law.shared);
  how.step = step.seconds;
  how.automatic = law.automatic;
  how.together = kTogether * query.voxel;
  how.sinks = kSinks * query.voxel;
  step.keepsAwake = false;
  if (step.touch) leaving.touched(contact);
  if (step.seconds > 0 && !step.touch && canLeave(sides) &&
      leaving.update(query, contact, narrowPhase.settings().leavingSpeed, step.seconds)) {
    how.automatic.reset();
    how.leavingSpeed = leaving.speed();
    step.keepsAwake = true;
    return writer.write(sides, leaving.contact(), how);
  }
  how.stopsFrom = std::max(query.voxel, sweptFrom(*sides.wrapA, *sides.wrapB));
  if (law.remembering)
    how.shared = memory.row(*law.remembering, sides, contact, writer.manifolds(), step.ahead());
  writer.write(sides, contact, how);
  if (law.remembering) memory.remember(sides, writer.manifolds());
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

void PairState::count(const PairStep& step, const PairSides& sides, double seconds) {
  const PairQuery& query = step.query;
  const ContactResult& contact = step.contact;
  const Answer how = step.how;
  LevelCount used;
  if (how != Answer::Shapes && query.levels.tolerance > 0)
    used = {query.levels.isCoarse(), query.levels.eased > 0,
            how == Answer::Moved ? 0 : levels.refined()};
  narrowPhase.count(seconds, contact.samples, contact.points.size(), how, used);
  setName(*sides.wrapA, *sides.wrapB);
  summary.last = how;
  summary.searched += how == Answer::Searched;
  summary.shapes += how == Answer::Shapes;
  summary.moved += how == Answer::Moved;
  summary.device += how == Answer::Device;
  summary.seconds += seconds;
  double error = how == Answer::Shapes ? query.shapeError : depthError(query.a, query.b, contact);
  if (how != Answer::Shapes && !contact.patches.empty())
    error = std::max(error, query.levels.error);
  if (how == Answer::Moved) error += moved.error(query.voxel);
  summary.error = error;
  summary.expectedError = std::max(summary.expectedError, error);
  summary.depth = depthOf(contact);
  summary.level = contact.level;
  summary.tolerance = query.levels.tolerance;
  summary.work = finder.work();
  summary.work.bricks += staying.compared();
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

void PairState::setName(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b) {
  summary.a = a.getCollisionObject(), summary.b = b.getCollisionObject();
  child[0] = a.m_index, child[1] = b.m_index;
}

void PairState::close(const PairStep& step, const PairSides& sides, double seconds) {
  count(step, sides, step.earlier + seconds);
  closeStep(step, sides);
  staying.keep(step.query, clearAfter(step));
}

// The query that process() will make in this step if nothing changes until then.
std::size_t PairState::prepare(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                               const btDispatcherInfo& info) {
  setStage(Stage::None);
  if (!std::exchange(processed, false) || staying.holds(a, b, info)) return 0;
  openStep();
  now.seconds = info.m_timeStep;
  now.touch.reset();
  // Without lockToRead(): no pair with a soft body is processed yet, and of 10,000 pairs the lock
  // was most of the time.
  now.query = reader.read(narrowPhase.settings(), a, b, now.seconds, true);
  if (now.query.wrong || now.query.apart || isSwept(a, b, info)) return 0;
  aim(now, a, b);
  setStage(Stage::Read);
  return now.query.byShapes || isKnown(now.query) ? 0 : 1 + finder.sampleLookups();
}

void PairState::searched(double seconds, Answer how) {
  now.how = how;
  now.earlier = seconds;
  setStage(Stage::Searched);
}

// All of the pair's step that other pairs do not feel. A new manifold is left to the walk, since
// their order is the solver's.
bool PairState::finish(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b) {
  const auto start = Clock::now();
  const bool known = stage() == Stage::Searched;
  setStage(Stage::None);  // what throws is left to the walk
  find(now, a, b, known);
  adjust(now, a, b);
  processed = true;
  const PairSides sides = now.sides(a, b);
  const std::size_t patches = now.contact.patches.size();
  now.keepsAwake.reset();
  if (std::max<std::size_t>(patches, 1) <= writer.manifolds().size()) write(now, sides);
  close(now, sides, since(start));
  if (now.keepsAwake == false) return true;
  setStage(Stage::Found);
  return false;
}

void PairState::ask(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                    const btDispatcherInfo& info, btManifoldResult& result) {
  const auto start = Clock::now();
  if (stage() == Stage::Searched) setStage(Stage::None);  // its IDs are this query's now
  PairStep query;
  query.isStep = false;
  query.query = read(a, b, info.m_timeStep, false, gapOf(result));
  if (query.query.wrong) narrowPhase.countFailure(query.query.wrong);
  if (query.query.wrong || query.query.apart) return writer.clear();
  find(query, a, b, false);
  adjust(query, a, b);
  const PairSides sides = query.sides(a, b);
  reportTo(result, sides, query.query.a, query.query.b, query.contact);
  count(query, sides, since(start));
}

// A step, or what is left of it after prepare(), a search and finish().
void PairState::walk(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                     const btDispatcherInfo& info) {
  const auto start = Clock::now();
  const Stage done = stage();
  setStage(Stage::None);
  if (done == Stage::Found) {
    if (!now.keepsAwake.has_value()) write(now, now.sides(a, b));
    if (*now.keepsAwake) keepAwake(narrowPhase, now.sides(a, b));
    return;
  }
  if (staying.holds(a, b, info)) return;
  openStep(), staying.forget();
  PairQuery query = read(a, b, info.m_timeStep, true);
  if (query.wrong) narrowPhase.countFailure(query.wrong);
  now.touch = query.wrong ? std::nullopt : sweepOn(a, b, info, query);
  if (query.wrong || query.apart) {
    leaving.reset();
    return writer.clear();
  }
  const bool sweeps = now.touch.has_value();
  now.seconds = info.m_timeStep;
  std::swap(now.query, query);
  aim(now, a, b);
  const bool known = done == Stage::Searched && !sweeps && sameQuery(now.query, query);
  find(now, a, b, known);
  adjust(now, a, b);
  const PairSides sides = now.sides(a, b);
  write(now, sides);
  if (*now.keepsAwake) keepAwake(narrowPhase, sides);
  close(now, sides, since(start));
}

void PairState::process(AheadPair& self, const btCollisionObjectWrapper& a,
                        const btCollisionObjectWrapper& b, const btDispatcherInfo& info,
                        btManifoldResult& result) {
  if (!std::exchange(weighed, true))
    for (const btCollisionObjectWrapper* wrap : {&a, &b})
      narrowPhase.checkMatter(*wrap->getCollisionObject());
  setName(a, b);
  // Bullet's queries derive from btManifoldResult; its solver does not.
  if (typeid(result) != typeid(btManifoldResult)) return ask(a, b, info, result);
  processed = true;
  if (lookAhead && lookAhead->step() > 0 && (a.m_parent || b.m_parent))
    lookAhead->remember(self, a, b, slot);
  walk(a, b, info);
}

}  // namespace cloudcontact
