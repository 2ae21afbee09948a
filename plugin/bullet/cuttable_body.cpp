// The cloud's frame is fixed to the matter. A cut moves Bullet's frame (center of mass, principal
// axes) in it. The cloud is the child of a compound shape, whose child transform makes up for the
// difference. Pairs see the child's frame, which does not move, so contacts keep IDs and impulses.
#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/Dynamics/btActionInterface.h>
#include <cloudcontact/bullet/cuttable_body.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "bullet/body_pieces.h"
#include "bullet/convert.h"
#include "voxels/cut_between.h"

namespace cloudcontact {

namespace {

// Matter that moves rigidly with the body.
MovingMatter moving(const MassProperties& matter, const Pose& cloud, const Motion& motion) {
  const Eigen::Matrix3d turn = cloud.orientation.toRotationMatrix();
  MovingMatter m;
  m.mass = matter.mass;
  m.center = cloud.toWorld(matter.centerOfMass);
  m.momentum = matter.mass * motion.at(m.center);
  m.angularMomentum =
      m.center.cross(m.momentum) + turn * matter.inertia * turn.transpose() * motion.angular;
  return m;
}

// Throws std::invalid_argument if `after` is not a cut `before`.
void validate(const Cloud& before, const Cloud& after) {
  if (after.empty() || !sameGrid(before, after) ||
      after.materials().size() != before.materials().size())
    throw std::invalid_argument("CuttableBody: the cloud has another grid than the body's");
  if (!cutsBetween(after, before).empty())
    throw std::invalid_argument(
        "CuttableBody: a cut only takes away; the cloud has more matter somewhere than the body");
}

// Copies the settings that a piece inherits from its body.
void inherit(const btRigidBody& from, btRigidBody& to) {
  to.setFriction(from.getFriction());
  to.setRollingFriction(from.getRollingFriction());
  to.setSpinningFriction(from.getSpinningFriction());
  to.setRestitution(from.getRestitution());
  to.setDamping(from.getLinearDamping(), from.getAngularDamping());
  to.setSleepingThresholds(from.getLinearSleepingThreshold(), from.getAngularSleepingThreshold());
  to.setFlags(from.getFlags());
  to.setCollisionFlags(from.getCollisionFlags());
  to.setUserPointer(from.getUserPointer());
  to.setGravity(from.getGravity());
  if (from.getActivationState() == DISABLE_DEACTIVATION)
    to.setActivationState(DISABLE_DEACTIVATION);
}

// Edge searches (FieldSettings::edgeSearches) in a step without a cut.
constexpr int kSearchesOfQuietStep = 10;

// Work on the pieces of gradual cuts in a step [about us of one core; PacedTask].
constexpr double kWorkOfStep = 3000;

constexpr double kArrivalCost = 400;  // of a field that takes the place of another [us]
constexpr double kAllWork = std::numeric_limits<double>::infinity();

void merge(CutOutcome& into, CutOutcome more) {
  for (auto& piece : more.fallen) into.fallen.push_back(std::move(piece));
  MovingMatter& sum = into.cutAway;
  const double mass = sum.mass + more.cutAway.mass;
  if (mass > 0)
    sum.center = (sum.mass * sum.center + more.cutAway.mass * more.cutAway.center) / mass;
  sum.mass = mass;
  sum.momentum += more.cutAway.momentum;
  sum.angularMomentum += more.cutAway.angularMomentum;
  into.frame = into.frame * more.frame;
  into.gone = into.gone || more.gone;
}

}  // namespace

// The world calls it at the end of each step.
struct CuttableBody::State : btActionInterface {
  CuttableBodySettings settings;
  BodyMatter matter;  // its field may be an earlier one, while gradual cuts are behind
  BodyMatter felt;    // the matter of that field
  bool behind = false;
  std::optional<PieceWork> work;  // none: not begun
  bool worked = false;            // since the last step
  Pose frame;                     // of the rigid body, in the cloud's frame
  std::unique_ptr<CloudShape> shape;
  std::unique_ptr<btCompoundShape> compound;
  std::unique_ptr<btRigidBody> body;
  btDynamicsWorld* world = nullptr;
  int group = 0, mask = 0;

  // Not yet in a world. `now`: `before` after cuts, with its field.
  State(const CuttableBodySettings& how, BodyMatter now, BodyMatter before, const Pose& place,
        const Motion& motion);
  ~State() override { leaveWorld(); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void leaveWorld();
  void updateAction(btCollisionWorld*, btScalar) override;
  void debugDraw(btIDebugDraw*) override {}

  Pose place() const { return toPose(body->getWorldTransform()) * frame.inverse(); }
  Motion motion() const {
    return {toVec3(body->getLinearVelocity()), toVec3(body->getAngularVelocity()),
            toVec3(body->getWorldTransform().getOrigin())};
  }
  MovingMatter moving(const std::vector<MatterSums>& sums) const;
  void settle(const Pose& cloudPlace, const Motion& motion);
  void searchEdges(std::optional<int> most);
  void moveContacts(const Pose& byInverse);
  void lighten();
  bool startWork();
  PieceSettings pieceSettings() const {
    return {settings.densities, settings.leastPiece, settings.threads};
  }
  CutOutcome goOn(double budget);
  CutOutcome arrive();
  CutOutcome become(std::vector<BodyMatter> pieces, std::span<const VoxelCut> since);
  void stay(BodyMatter piece, std::span<const VoxelCut> since);
  std::unique_ptr<State> fallen(BodyMatter piece, std::span<const VoxelCut> since) const;
  CutOutcome vanish();
};

CuttableBody::State::State(const CuttableBodySettings& how, BodyMatter now, BodyMatter before,
                           const Pose& place, const Motion& motion)
    : settings(how), matter(std::move(now)), felt(std::move(before)) {
  behind = !(matter.sums == felt.sums);
  shape = std::make_unique<CloudShape>(felt.field);
  shape->setFidelity({0, 0, true});  // the first cut must not move what rests
  shape->law = settings.law;
  compound = std::make_unique<btCompoundShape>();
  compound->addChildShape(btTransform::getIdentity(), shape.get());
  body = std::make_unique<btRigidBody>(
      btRigidBody::btRigidBodyConstructionInfo(1, nullptr, compound.get(), btVector3(1, 1, 1)));
  settle(place, motion);
}

// Of matter that moves with the body.
MovingMatter CuttableBody::State::moving(const std::vector<MatterSums>& sums) const {
  return cloudcontact::moving(massPropertiesOf(sums, matter.cloud, settings.densities), place(),
                              motion());
}

// Sets mass, frame and velocity of the rigid body from its matter.
void CuttableBody::State::settle(const Pose& cloudPlace, const Motion& motion) {
  const MassProperties m = massPropertiesOf(matter.sums, matter.cloud, settings.densities);
  const PrincipalAxes principal = principalAxes(m.inertia, frame.orientation);
  frame = {principal.orientation, m.centerOfMass};
  const Pose where = cloudPlace * frame;
  compound->updateChildTransform(0, toBullet(frame.inverse()), true);
  body->setMassProps(static_cast<btScalar>(m.mass), toBullet(principal.moments));
  body->setLinearVelocity(toBullet(motion.at(where.position)));
  body->setAngularVelocity(toBullet(motion.angular));
  body->setCenterOfMassTransform(toBullet(where));
  body->updateInertiaTensor();
}

void CuttableBody::State::searchEdges(std::optional<int> most) {
  if (felt.field->unsettled() == 0) return;
  felt.field = renewed(felt.field, felt.cloud, fieldSettings(settings.threads, most));
  matter.field = felt.field;
  shape->setField(felt.field);
  if (world) world->updateSingleAabb(body.get());
}

// A step with a cut has had its share of work. Pieces that fall off wait for their owner.
void CuttableBody::State::updateAction(btCollisionWorld*, btScalar) {
  if (std::exchange(worked, false)) return;
  if (!behind) return searchEdges(kSearchesOfQuietStep);
  if (!startWork()) return;
  work->task.run(kWorkOfStep);
  if (work->task.done() && work->pieces->size() == 1 &&
      work->pieces->front().sums == work->matter.sums)
    arrive();
}

void CuttableBody::State::leaveWorld() {
  if (!world) return;
  world->removeAction(this);
  world->removeRigidBody(body.get());
  world = nullptr;
}

// Bullet keeps points in the bodies' frames, which a cut moves.
void CuttableBody::State::moveContacts(const Pose& byInverse) {
  if (!world) return;
  const btTransform move = toBullet(byInverse);
  btDispatcher& dispatcher = *world->getDispatcher();
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      btManifoldPoint& point = manifold.getContactPoint(k);
      if (manifold.getBody0() == body.get()) point.m_localPointA = move * point.m_localPointA;
      if (manifold.getBody1() == body.get()) point.m_localPointB = move * point.m_localPointB;
    }
  }
}

// Follows a change of `matter`, where the matter that is left keeps its motion.
void CuttableBody::State::lighten() {
  const Pose before = frame;
  settle(place(), motion());
  moveContacts(frame.inverse() * before);
  if (world) world->updateSingleAabb(body.get());
  body->activate();
}

// False if the work is done and waits.
bool CuttableBody::State::startWork() {
  if (!work) work.emplace(felt, matter, pieceSettings());
  return !work->task.done();
}

// Works on gradual cuts until the budget is spent or none is left.
CutOutcome CuttableBody::State::goOn(double budget) {
  CutOutcome outcome;
  worked = true;
  const double whole = budget;
  while (behind && budget > 0) {
    if (startWork()) budget = work->task.run(budget);
    if (!work->task.done()) continue;
    // Pieces that fall are the work of a step of their own, for the caller has work with them.
    const bool falls = work->pieces->size() > 1 && whole < kAllWork;
    if (falls && budget < whole) break;
    merge(outcome, arrive());
    budget -= falls ? whole : kArrivalCost;
  }
  return outcome;
}

// The work is done: the body becomes its heaviest piece.
CutOutcome CuttableBody::State::arrive() {
  const PieceWork done = std::move(*work);
  work.reset();
  return become(std::move(*done.pieces), done.since);
}

// Of the pieces of `matter` before the cuts `since`. What is in none of them counts as cut away.
CutOutcome CuttableBody::State::become(std::vector<BodyMatter> pieces,
                                       std::span<const VoxelCut> since) {
  if (pieces.empty()) return vanish();
  const auto mass = [&](const BodyMatter& piece) { return bodyMass(piece, settings.densities); };
  const auto heaviest =
      std::max_element(pieces.begin(), pieces.end(),
                       [&](const BodyMatter& a, const BodyMatter& b) { return mass(a) < mass(b); });
  std::vector<MatterSums> rest = matter.sums;
  CutOutcome outcome;
  for (auto piece = pieces.begin(); piece != pieces.end(); ++piece) {
    if (piece == heaviest) continue;
    std::unique_ptr<CuttableBody> off(new CuttableBody(fallen(std::move(*piece), since)));
    const std::vector<MatterSums>& sums = off->state_->matter.sums;
    if (coverageOf(sums) == 0) continue;
    rest = sumOf(rest, sums, true);
    if (world) off->addTo(*world, group, mask);
    outcome.fallen.push_back(std::move(off));
  }
  const Pose before = frame;
  const Pose cloudPlace = place();
  const Motion withAll = motion();
  stay(std::move(*heaviest), since);
  outcome.cutAway = cloudcontact::moving(
      massPropertiesOf(sumOf(rest, matter.sums, true), matter.cloud, settings.densities),
      cloudPlace, withAll);
  outcome.frame = before.inverse() * frame;
  return outcome;
}
// The body is `piece` after the cuts `since`.
void CuttableBody::State::stay(BodyMatter piece, std::span<const VoxelCut> since) {
  const bool same = piece.sums == felt.sums;
  matter = since.empty() ? piece : cutMatter(piece, since);
  behind = !(matter.sums == piece.sums);
  if (same) return;
  felt = std::move(piece);
  shape->setField(felt.field);
  lighten();
}

// A piece that falls off.
std::unique_ptr<CuttableBody::State> CuttableBody::State::fallen(
    BodyMatter piece, std::span<const VoxelCut> since) const {
  BodyMatter now = since.empty() ? piece : cutMatter(piece, since);
  auto state =
      std::make_unique<State>(settings, std::move(now), std::move(piece), place(), motion());
  state->shape->inherit(*shape);
  inherit(*body, *state->body);
  return state;
}

// Nothing is left that could be a body.
CutOutcome CuttableBody::State::vanish() {
  CutOutcome outcome;
  outcome.cutAway = moving(matter.sums);
  outcome.gone = true;
  leaveWorld();
  behind = false;
  work.reset();
  return outcome;
}

CuttableBody::CuttableBody(const Cloud& cloud, const btTransform& place,
                           const CuttableBodySettings& settings) {
  if (!(settings.leastPiece >= 0))
    throw std::invalid_argument("CuttableBody: leastPiece must not be negative [kg]");
  BodyMatter matter{cloud, matterSums(cloud),
                    SurfaceField::build(cloud, fieldSettings(settings.threads, std::nullopt)),
                    false};
  state_ = std::make_unique<State>(settings, matter, matter, toPose(place), Motion{});
}

CuttableBody::CuttableBody(std::unique_ptr<State> state) : state_(std::move(state)) {}
CuttableBody::~CuttableBody() = default;

btRigidBody& CuttableBody::body() {
  return *state_->body;
}
const btRigidBody& CuttableBody::body() const {
  return *state_->body;
}
CloudShape& CuttableBody::shape() {
  return *state_->shape;
}
const Cloud& CuttableBody::cloud() const {
  return state_->matter.cloud;
}
btTransform CuttableBody::cloudPlace() const {
  return toBullet(state_->place());
}

MovingMatter CuttableBody::matter() const {
  const btRigidBody& body = *state_->body;
  if (coverageOf(state_->matter.sums) == 0 || body.getInvMass() == 0) return {};
  const Pose pose = toPose(body.getWorldTransform());
  const Vec3 inverse = toVec3(body.getInvInertiaDiagLocal());
  const MassProperties matter{0, 1 / double(body.getInvMass()), Vec3::Zero(),
                              Eigen::Matrix3d(inverse.cwiseInverse().asDiagonal())};
  return moving(matter, pose, state_->motion());
}

double CuttableBody::volume() const {
  const double h = state_->matter.cloud.voxelSize();
  return static_cast<double>(coverageOf(state_->matter.sums)) * h * h * h / 255;
}

void CuttableBody::addTo(btDynamicsWorld& world, int group, int mask) {
  leaveWorld();
  state_->world = &world;
  state_->group = group;
  state_->mask = mask;
  world.addRigidBody(state_->body.get(), group, mask);
  world.addAction(state_.get());
}

void CuttableBody::leaveWorld() {
  state_->leaveWorld();
}

btDynamicsWorld* CuttableBody::world() {
  return state_->world;
}

bool CuttableBody::behind() const {
  return state_->behind;
}

CutOutcome CuttableBody::goOn(double share) {
  return state_->goOn(share * kWorkOfStep);
}

CutOutcome CuttableBody::settle() {
  CutOutcome outcome = state_->goOn(kAllWork);
  if (!outcome.gone) state_->searchEdges(std::nullopt);
  return outcome;
}

CutOutcome CuttableBody::cut(Span<const VoxelCut> cuts) {
  return become(cutCloud(state_->matter.cloud, cuts));
}

CutOutcome CuttableBody::become(const Cloud& after) {
  State& own = *state_;
  validate(own.matter.cloud, after);
  if (own.behind) {
    const std::vector<VoxelCut> cuts = cutsBetween(own.matter.cloud, after);
    CutOutcome outcome = own.goOn(kAllWork);
    if (!outcome.gone && !cuts.empty()) merge(outcome, cut(cuts));
    return outcome;
  }
  own.worked = true;
  CutOutcome outcome = own.become(piecesOf(own.felt, after, own.pieceSettings(), {}), {});
  if (outcome.gone) own.matter = {after, matterSums(after), own.felt.field, false};
  return outcome;
}

CutOutcome CuttableBody::cutGradually(Span<const VoxelCut> cuts, double share) {
  State& own = *state_;
  BodyMatter left = cutMatter(own.matter, cuts);
  CutOutcome outcome;
  if (!(left.sums == own.matter.sums)) {
    const std::vector<MatterSums> away = sumOf(own.matter.sums, left.sums, true);
    if (coverageOf(left.sums) == 0) {
      outcome = own.vanish();
      own.matter = std::move(left);
      return outcome;
    }
    const Pose before = own.frame;
    outcome.cutAway = own.moving(away);
    own.matter = std::move(left);
    own.behind = true;
    if (own.work) own.work->since.insert(own.work->since.end(), cuts.begin(), cuts.end());
    own.lighten();
    outcome.frame = before.inverse() * own.frame;
  }
  merge(outcome, own.goOn(share * kWorkOfStep));
  return outcome;
}

}  // namespace cloudcontact
