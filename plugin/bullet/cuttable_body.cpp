// The cloud's frame is fixed to the matter. A cut moves Bullet's frame (center of mass, principal
// axes) in it. The cloud is the child of a compound shape, whose child transform makes up for the
// difference. Pairs see the child's frame, which does not move, so contacts keep IDs and impulses.
#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/Dynamics/btActionInterface.h>
#include <cloudcontact/bullet/cuttable_body.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/parallel.h"
#include "bullet/convert.h"

namespace cloudcontact {

namespace {

struct Principal {
  Pose frame;    // in the cloud's frame
  Vec3 inertia;  // [kg m^2]
};

// The axes in the order and direction nearest to those of `near`, so that a small cut does not swap
// them.
Principal principalOf(const MassProperties& matter, const Eigen::Quaterniond& near) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matter.inertia);
  const Eigen::Matrix3d found = solver.eigenvectors(), wanted = near.toRotationMatrix();
  Eigen::Matrix3d axes;
  Vec3 inertia;
  bool taken[3] = {};
  for (int i = 0; i < 3; ++i) {
    int best = -1;
    for (int k = 0; k < 3; ++k)
      if (!taken[k] && (best < 0 || std::abs(found.col(k).dot(wanted.col(i))) >
                                        std::abs(found.col(best).dot(wanted.col(i)))))
        best = k;
    taken[best] = true;
    const double side = found.col(best).dot(wanted.col(i)) < 0 ? -1 : 1;
    axes.col(i) = side * found.col(best);
    inertia[i] = solver.eigenvalues()[best];
  }
  if (axes.determinant() < 0) axes.col(2) = -axes.col(2);
  return {{Eigen::Quaterniond(axes).normalized(), matter.centerOfMass}, inertia};
}

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

std::vector<MatterSums> sumOf(const std::vector<MatterSums>& a, const std::vector<MatterSums>& b,
                              bool less) {
  std::vector<MatterSums> sum = a;
  for (std::size_t i = 0; i < sum.size(); ++i) less ? sum[i] -= b[i] : sum[i] += b[i];
  return sum;
}

std::int64_t coverageOf(const std::vector<MatterSums>& sums) {
  std::int64_t all = 0;
  for (const MatterSums& s : sums) all += s.mass;
  return all;
}

// Throws std::invalid_argument if `after` is not a cut `before`.
void validate(const Cloud& before, const Cloud& after) {
  if (after.empty() || after.bricks() != before.bricks() ||
      after.voxelSize() != before.voxelSize() || after.origin() != before.origin() ||
      after.materials().size() != before.materials().size())
    throw std::invalid_argument("CuttableBody: the cloud has another grid than the body's");
  const Cloud::Voxels &a = before.voxels(), &b = after.voxels();
  for (std::size_t t = 0; t < a.table.size(); ++t) {
    const std::int32_t old = a.table[t], now = b.table[t];
    if (now == kEmptyBrick || old == kSolidBrick) continue;
    bool less = old >= 0 && now >= 0;
    for (std::size_t k = 0; less && k < kBrickVoxels; ++k)
      less = b.coverage[static_cast<std::size_t>(now)][k] <=
             a.coverage[static_cast<std::size_t>(old)][k];
    if (!less)
      throw std::invalid_argument(
          "CuttableBody: a cut only takes away; the cloud has more matter "
          "somewhere than the body");
  }
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

// Edge searches (FieldSettings::edgeSearches) in a step without a cut, and in one with a cut of
// some voxels. They take the time that the cut leaves: a search costs as much as 30 voxels.
constexpr int kSearchesOfQuietStep = 16;
int searchesOfCut(std::int64_t voxels) {
  return static_cast<int>(std::max(std::int64_t{0}, 6 - voxels / 30));
}

// A piece of a body that was cut.
struct Piece {
  Cloud cloud;
  std::vector<MatterSums> sums;
  double mass = 0;
  std::shared_ptr<const SurfaceField> field;
};

}  // namespace

// The world calls it at the end of each step.
struct CuttableBody::State : btActionInterface {
  CuttableBodySettings settings;
  Cloud cloud;
  bool whole = false;   // the cloud is known to be one part
  bool wasCut = false;  // since the last step
  std::vector<MatterSums> sums;
  std::shared_ptr<const SurfaceField> field;
  Pose frame;  // of the rigid body, in the cloud's frame
  std::unique_ptr<CloudShape> shape;
  std::unique_ptr<btCompoundShape> compound;
  std::unique_ptr<btRigidBody> body;
  btDynamicsWorld* world = nullptr;
  int group = 0, mask = 0;

  // Of known matter; not yet in a world.
  State(const CuttableBodySettings& how, const Cloud& matter, std::vector<MatterSums> known,
        std::shared_ptr<const SurfaceField> surface, const Pose& place, const Motion& motion);
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
  MassProperties matter() const { return massPropertiesOf(sums, cloud, settings.densities); }
  FieldSettings fieldSettings(std::optional<int> edgeSearches) const {
    FieldSettings how;
    how.threads = settings.threads;
    how.renewable = true;
    how.edgeSearches = edgeSearches;
    return how;
  }
  void settle(const Pose& cloudPlace, const Motion& motion);
  std::shared_ptr<const SurfaceField> fieldOf(const Cloud& piece, std::int64_t coverage) const;
  void searchEdges(std::optional<int> most);
  void moveContacts(const Pose& byInverse);
  std::vector<Piece> piecesOf(const Cloud& after) const;
  void become(Piece piece, const Pose& place, const Motion& motion);
  std::unique_ptr<State> fallen(const Piece& piece, const Pose& place, const Motion& motion) const;
};

CuttableBody::State::State(const CuttableBodySettings& how, const Cloud& matterCloud,
                           std::vector<MatterSums> known,
                           std::shared_ptr<const SurfaceField> surface, const Pose& place,
                           const Motion& motion)
    : settings(how), cloud(matterCloud), sums(std::move(known)), field(std::move(surface)) {
  shape = std::make_unique<CloudShape>(field);
  shape->law = settings.law;
  compound = std::make_unique<btCompoundShape>();
  compound->addChildShape(btTransform::getIdentity(), shape.get());
  body = std::make_unique<btRigidBody>(
      btRigidBody::btRigidBodyConstructionInfo(1, nullptr, compound.get(), btVector3(1, 1, 1)));
  settle(place, motion);
}

// Sets mass, frame and velocity of the rigid body from its matter.
void CuttableBody::State::settle(const Pose& cloudPlace, const Motion& motion) {
  const MassProperties m = matter();
  const Principal principal = principalOf(m, frame.orientation);
  frame = principal.frame;
  const Pose where = cloudPlace * frame;
  compound->updateChildTransform(0, toBullet(frame.inverse()), true);
  body->setMassProps(static_cast<btScalar>(m.mass), toBullet(principal.inertia));
  body->setLinearVelocity(toBullet(motion.at(where.position)));
  body->setAngularVelocity(toBullet(motion.angular));
  body->setCenterOfMassTransform(toBullet(where));
  body->updateInertiaTensor();
}

// Renews the body's field for a large piece; building is faster for a crumb. Null if the piece has
// no surface. `coverage`: the piece's.
std::shared_ptr<const SurfaceField> CuttableBody::State::fieldOf(const Cloud& piece,
                                                                 std::int64_t coverage) const {
  const std::int64_t all = coverageOf(sums);
  const FieldSettings how = fieldSettings(searchesOfCut((all - coverage) / 255));
  try {
    return 20 * coverage > all ? renewed(field, piece, how) : SurfaceField::build(piece, how);
  } catch (const std::invalid_argument&) {
    return nullptr;
  }
}

void CuttableBody::State::searchEdges(std::optional<int> most) {
  if (field->unsettled() == 0) return;
  field = renewed(field, cloud, fieldSettings(most));
  shape->setField(field);
  if (world) world->updateSingleAabb(body.get());
}

// A step with a cut has had its share of searches.
void CuttableBody::State::updateAction(btCollisionWorld*, btScalar) {
  if (!wasCut) searchEdges(kSearchesOfQuietStep);
  wasCut = false;
}

void CuttableBody::State::leaveWorld() {
  if (!world) return;
  world->removeAction(this);
  world->removeRigidBody(body.get());
  world = nullptr;
}

// The pieces that remain bodies of their own, in the order of their first voxels. Where there is
// one, only what the cut changed is summed up.
std::vector<Piece> CuttableBody::State::piecesOf(const Cloud& after) const {
  std::vector<Cloud> clouds = whole ? pieces(after, cloud) : pieces(after);
  std::vector<Piece> all(clouds.size());
  parallelFor(clouds.size(), settings.threads, [&](std::size_t k, int) {
    Piece& piece = all[k];
    piece.cloud = std::move(clouds[k]);
    piece.sums = all.size() == 1 ? matterSums(piece.cloud, cloud, sums) : matterSums(piece.cloud);
    piece.mass = massPropertiesOf(piece.sums, piece.cloud, settings.densities).mass;
    if (piece.mass >= settings.leastPiece)
      piece.field = fieldOf(piece.cloud, coverageOf(piece.sums));
  });
  std::erase_if(all, [](const Piece& piece) { return !piece.field; });
  return all;
}

void CuttableBody::State::become(Piece piece, const Pose& place, const Motion& motion) {
  const Pose before = frame;
  cloud = std::move(piece.cloud);
  sums = std::move(piece.sums);
  field = std::move(piece.field);
  whole = wasCut = true;
  shape->setField(field);
  settle(place, motion);
  moveContacts(frame.inverse() * before);
  if (world) world->updateSingleAabb(body.get());
  body->activate();
}

// A piece that falls off.
std::unique_ptr<CuttableBody::State> CuttableBody::State::fallen(const Piece& piece,
                                                                 const Pose& place,
                                                                 const Motion& motion) const {
  auto state =
      std::make_unique<State>(settings, piece.cloud, piece.sums, piece.field, place, motion);
  state->whole = true;
  state->shape->law = shape->law;
  inherit(*body, *state->body);
  return state;
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

CuttableBody::CuttableBody(const Cloud& cloud, const btTransform& place,
                           const CuttableBodySettings& settings) {
  FieldSettings how;
  how.threads = settings.threads;
  how.renewable = true;
  if (!(settings.leastPiece >= 0))
    throw std::invalid_argument("CuttableBody: leastPiece must not be negative [kg]");
  std::vector<MatterSums> sums = matterSums(cloud);
  state_ = std::make_unique<State>(settings, cloud, std::move(sums),
                                   SurfaceField::build(cloud, how), toPose(place), Motion{});
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
  return state_->cloud;
}
btTransform CuttableBody::cloudPlace() const {
  return toBullet(state_->place());
}

MovingMatter CuttableBody::matter() const {
  const btRigidBody& body = *state_->body;
  if (coverageOf(state_->sums) == 0 || body.getInvMass() == 0) return {};
  const Pose pose = toPose(body.getWorldTransform());
  const Vec3 inverse = toVec3(body.getInvInertiaDiagLocal());
  const MassProperties matter{0, 1 / double(body.getInvMass()), Vec3::Zero(),
                              Eigen::Matrix3d(inverse.cwiseInverse().asDiagonal())};
  return moving(matter, pose, state_->motion());
}

double CuttableBody::volume() const {
  const double h = state_->cloud.voxelSize();
  return static_cast<double>(coverageOf(state_->sums)) * h * h * h / 255;
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

void CuttableBody::settle() {
  state_->searchEdges(std::nullopt);
}

btDynamicsWorld* CuttableBody::world() {
  return state_->world;
}

CutOutcome CuttableBody::cut(std::span<const VoxelCut> cuts) {
  return become(cutCloud(state_->cloud, cuts));
}

CutOutcome CuttableBody::become(const Cloud& after) {
  State& own = *state_;
  validate(own.cloud, after);
  std::vector<Piece> left = own.piecesOf(after);
  std::vector<MatterSums> cutAway = own.sums;
  for (const Piece& piece : left) cutAway = sumOf(cutAway, piece.sums, true);
  const Pose place = own.place(), before = own.frame;
  const Motion motion = own.motion();
  CutOutcome outcome;
  outcome.cutAway =
      moving(massPropertiesOf(cutAway, own.cloud, own.settings.densities), place, motion);
  if (left.empty()) {
    leaveWorld();
    own.cloud = after;
    own.sums = matterSums(after);
    own.whole = false;
    outcome.gone = true;
    return outcome;
  }
  const auto heaviest = std::max_element(
      left.begin(), left.end(), [](const Piece& a, const Piece& b) { return a.mass < b.mass; });
  for (auto piece = left.begin(); piece != left.end(); ++piece) {
    if (piece == heaviest) continue;
    std::unique_ptr<CuttableBody> body(new CuttableBody(own.fallen(*piece, place, motion)));
    if (own.world) body->addTo(*own.world, own.group, own.mask);
    outcome.fallen.push_back(std::move(body));
  }
  if (coverageOf(heaviest->sums) == coverageOf(own.sums)) return outcome;  // nothing was cut
  own.become(std::move(*heaviest), place, motion);
  outcome.frame = before.inverse() * own.frame;
  return outcome;
}

}  // namespace cloudcontact
