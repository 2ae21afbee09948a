// Reads the rows from Bullet's manifolds and joints after a step (energy_audit.h).
#include "lab/energy_audit.h"

#include <algorithm>
#include <limits>

#include "scene/bullet_energy.h"

namespace cloudcontact::program::lab {
namespace {

bool isFree(const btRigidBody& body) {
  return body.getInvMass() > 0 && !body.isStaticOrKinematicObject();
}

Vec3 inertiaOf(const btRigidBody& body) {
  return fromBullet(body.getInvInertiaDiagLocal()).unaryExpr([](double inverse) {
    return inverse > 0 ? 1 / inverse : 0;
  });
}

double massOf(const btRigidBody& body) {
  return 1 / static_cast<double>(body.getInvMass());
}

double energyOf(const btRigidBody& body) {
  const Vec3 center = fromBullet(body.getWorldTransform().getOrigin());
  return kineticEnergy(body, massOf(body), inertiaOf(body)) -
         massOf(body) * fromBullet(body.getGravity()).dot(center);
}

Eigen::Matrix3d worldInertia(const btRigidBody& body) {
  Eigen::Matrix3d turn;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) turn(r, c) = body.getWorldTransform().getBasis()[r][c];
  return turn * inertiaOf(body).asDiagonal() * turn.transpose();
}

// As Bullet's solver adds it; its functions for implicit torques give a change of velocity.
Vec3 gyroscopicImpulse(const btRigidBody& body, const btContactSolverInfo& info,
                       const Eigen::Matrix3d& inertia, double seconds) {
  Vec3 impulse = Vec3::Zero();
  if (body.getFlags() & BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT)
    impulse -= seconds * fromBullet(body.computeGyroscopicForceExplicit(info.m_maxGyroscopicForce));
  if (body.getFlags() & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD)
    impulse += inertia * fromBullet(body.computeGyroscopicImpulseImplicit_World(btScalar(seconds)));
  if (body.getFlags() & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY)
    impulse += inertia * fromBullet(body.computeGyroscopicImpulseImplicit_Body(btScalar(seconds)));
  return impulse;
}

// What the point's spring stores once the bodies have parted by `parting` [m]. CloudContact states
// a secant for a spring that is flatter than it, and takes the difference from the damping.
double energyLeft(const btManifoldPoint& point, double depth, double parting, double seconds) {
  const double stored = springEnergy(point, depth);
  if (!(stored > 0)) return springEnergy(point, depth - parting);
  const double stated = point.m_combinedContactStiffness1;
  const double damping = std::min(0.0, double(point.m_combinedContactDamping1));
  const double slope = std::max(0.0, stated + damping / seconds);
  const double most = slope > 0 ? stated * depth / slope : parting;  // it does not pull
  const double way = std::min(parting, most);
  return stored - stated * depth * way + slope * way * way / 2;
}

}  // namespace

EnergyParts& EnergyParts::operator+=(const EnergyParts& other) {
  bodies += other.bodies, springs += other.springs, friction += other.friction;
  normals += other.normals, joints += other.joints, drivers += other.drivers;
  solver += other.solver, turning += other.turning, rest += other.rest, found += other.found;
  return *this;
}

EnergyAudit::EnergyAudit(btDynamicsWorld& world) : world_(world) {
  world_.addAction(this);
}

EnergyAudit::~EnergyAudit() {
  world_.removeAction(this);
  for (int i = 0; i < world_.getNumConstraints(); ++i) {
    const auto ours = feedback_.find(world_.getConstraint(i));
    if (ours != feedback_.end() && ours->first->getJointFeedback() == ours->second.get())
      ours->first->setJointFeedback(nullptr);
  }
}

void EnergyAudit::begin(double seconds) {
  const btCollisionObjectArray& objects = world_.getCollisionObjectArray();
  seconds_ = btScalar(seconds);  // as Bullet has it
  starts_.assign(static_cast<std::size_t>(objects.size()), {});
  for (int i = 0; i < objects.size(); ++i) {
    const auto* body = btRigidBody::upcast(objects[i]);
    if (body && isFree(*body)) starts_[i] = startOf(*body, seconds);
  }
  for (int i = 0; i < world_.getNumConstraints(); ++i) {
    btTypedConstraint* const joint = world_.getConstraint(i);
    if (joint->getJointFeedback()) continue;
    auto& own = feedback_[joint];
    own = std::make_unique<btJointFeedback>();
    joint->setJointFeedback(own.get());
  }
  begun_ = true;
}

EnergyAudit::Start EnergyAudit::startOf(const btRigidBody& body, double seconds) const {
  Start start;
  start.energy = energyOf(body);
  start.center = fromBullet(body.getWorldTransform().getOrigin());
  start.linear = fromBullet(body.getLinearVelocity());
  start.angular = fromBullet(body.getAngularVelocity());
  start.inertia = worldInertia(body);
  start.gyroscopic = gyroscopicImpulse(body, const_cast<btDynamicsWorld&>(world_).getSolverInfo(),
                                       start.inertia, seconds);
  return start;
}

void EnergyAudit::updateAction(btCollisionWorld*, btScalar) {
  if (!begun_) return;
  begun_ = false;
  ++steps_;
  step_ = {};
  addBodies();
  addContacts();
  addJoints();
  step_.rest = step_.bodies + step_.springs -
               (step_.friction + step_.normals + step_.joints + step_.drivers + step_.solver +
                step_.turning);
  sum_ += step_;
}

void EnergyAudit::addBodies() {
  const btCollisionObjectArray& objects = world_.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i) {
    const auto* body = btRigidBody::upcast(objects[i]);
    if (!body || !isFree(*body)) continue;
    const Start& start = starts_[i];
    const Vec3 linear = fromBullet(body->getLinearVelocity());
    const Vec3 angular = fromBullet(body->getAngularVelocity());
    const Vec3 push = linear - start.linear, spin = angular - start.angular;
    step_.bodies += energyOf(*body) - start.energy;
    step_.solver -= 0.5 * massOf(*body) * push.squaredNorm() + 0.5 * spin.dot(start.inertia * spin);
    step_.turning += angular.dot(start.gyroscopic) +
                     0.5 * angular.dot((worldInertia(*body) - start.inertia) * angular);
  }
}

// Kinematic bodies are where Bullet has put them before it solved the rows, with that velocity.
EnergyAudit::Side EnergyAudit::sideOf(const btCollisionObject& object, const Vec3& place) const {
  Side side;
  const auto* body = btRigidBody::upcast(&object);
  if (!body) return side;
  const Vec3 linear = fromBullet(body->getLinearVelocity());
  const Vec3 angular = fromBullet(body->getAngularVelocity());
  if (body->isKinematicObject()) {
    side.driven = true;
    const Vec3 arm = place - fromBullet(body->getWorldTransform().getOrigin());
    side.before = side.after = linear + angular.cross(arm);
  } else if (isFree(*body)) {
    const Start& start = starts_[body->getWorldArrayIndex()];
    const Vec3 arm = place - start.center;
    side.before = start.linear + start.angular.cross(arm);
    side.after = linear + angular.cross(arm);
  }
  return side;
}

// Of an impulse on a, and its reverse on b. What a driver gives is what the bodies get beyond that.
double EnergyAudit::work(const Vec3& impulse, const Side& a, const Side& b) {
  if (a.driven) step_.drivers -= impulse.dot(a.after);
  if (b.driven) step_.drivers += impulse.dot(b.after);
  return impulse.dot(a.after - b.after);
}

void EnergyAudit::addContacts() {
  btDispatcher& dispatcher = *world_.getDispatcher();
  stored_ = 0;
  const double before = left_;
  left_ = 0;
  std::swap(before_, now_);
  now_.clear();
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i)
    addManifold(*dispatcher.getManifoldByIndexInternal(i));
  step_.springs = left_ - stored_;
  step_.found = steps_ > 1 ? stored_ - before : 0;
}

void EnergyAudit::addManifold(const btPersistentManifold& manifold) {
  const btCollisionObject &a = *manifold.getBody0(), &b = *manifold.getBody1();
  if (!a.hasContactResponse() || !b.hasContactResponse()) return;
  if (a.isStaticOrKinematicObject() && b.isStaticOrKinematicObject()) return;
  EnergyRow row;
  row.a = &a, row.b = &b, row.step = steps_;
  const int count = manifold.getNumContacts();
  row.patchNew = true;
  for (int i = 0; i < count; ++i) {
    row.point = manifold.getContactPoint(i).m_partId0;
    row.patchNew = row.patchNew && !wasThere(row);
  }
  for (int i = 0; i < count; ++i) {
    const btManifoldPoint& point = manifold.getContactPoint(i);
    const Vec3 place = fromBullet(point.m_localPointA);
    row.point = point.m_partId0;
    now_[{row.a, row.b, row.point}] = {place, 0};
    if (point.getDistance() > manifold.getContactProcessingThreshold()) continue;
    row.isNew = !wasThere(row);
    row.renamed = row.isNew && isRenamed(manifold, row, place);
    addPoint(point, row, sideOf(a, fromBullet(point.getPositionWorldOnA())),
             sideOf(b, fromBullet(point.getPositionWorldOnB())));
  }
}

void EnergyAudit::addPoint(const btManifoldPoint& point, const EnergyRow& row, const Side& a,
                           const Side& b) {
  const Vec3 normal = fromBullet(point.m_normalWorldOnB);
  const double push = point.m_appliedImpulse;
  const double parting = seconds_ * normal.dot(a.after - b.after);
  const double normals = work(push * normal, a, b) + springs(point, row, parting);
  step_.normals += normals;
  // A row that bounces may give that speed back.
  const double bounce =
      static_cast<double>(point.m_combinedRestitution) * normal.dot(a.before - b.before);
  note(row, RowKind::Normal, normals + push * std::min(0.0, bounce));
  const btVector3* const axes[] = {&point.m_lateralFrictionDir1, &point.m_lateralFrictionDir2};
  const double impulses[] = {static_cast<double>(point.m_appliedImpulseLateral1),
                             static_cast<double>(point.m_appliedImpulseLateral2)};
  for (int i = 0; i < 2; ++i) {
    const double friction = work(impulses[i] * fromBullet(*axes[i]), a, b);
    step_.friction += friction;
    note(row, i == 0 ? RowKind::Friction1 : RowKind::Friction2, friction);
  }
}

// Their change while the bodies part by `parting` [m].
double EnergyAudit::springs(const btManifoldPoint& point, const EnergyRow& row, double parting) {
  const double depth = -static_cast<double>(point.getDistance());
  const double stored = springEnergy(point, depth);
  const double left = energyLeft(point, depth, parting, seconds_);
  stored_ += stored, left_ += left;
  now_[{row.a, row.b, row.point}].left = left;
  const auto known = before_.find({row.a, row.b, row.point});
  const double found = stored - (known == before_.end() ? 0 : known->second.left);
  if (steps_ > 1) note(row, RowKind::Spring, found);
  return left - stored;
}

void EnergyAudit::note(EnergyRow row, RowKind kind, double energy) {
  if (!(energy > 0)) return;
  EnergyMade& made = made_[static_cast<int>(kind)];
  ++made.rows;
  made.energy += energy;
  if (row.isNew) made.byNew += energy;
  if (energy <= made.worst.energy) return;
  row.kind = kind, row.energy = energy;
  made.worst = row;
}

const EnergyRow& EnergyAudit::worst() const {
  const EnergyMade* most = &made_[0];
  for (const RowKind kind : {RowKind::Friction1, RowKind::Friction2})
    if (made(kind).worst.energy > most->worst.energy) most = &made(kind);
  return most->worst;
}

bool EnergyAudit::wasThere(const EnergyRow& row) const {
  return before_.count({row.a, row.b, row.point}) > 0;
}

bool EnergyAudit::isRenamed(const btPersistentManifold& manifold, const EnergyRow& row,
                            const Vec3& place) const {
  double nearest = std::numeric_limits<double>::infinity();
  std::vector<int> present;
  btDispatcher& dispatcher = *world_.getDispatcher();
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
    const btPersistentManifold& other = *dispatcher.getManifoldByIndexInternal(m);
    if (other.getBody0() != manifold.getBody0() || other.getBody1() != manifold.getBody1())
      continue;
    for (int i = 0; i < other.getNumContacts(); ++i) {
      const btManifoldPoint& point = other.getContactPoint(i);
      present.push_back(point.m_partId0);
      if (point.m_partId0 == row.point) continue;
      nearest = std::min(nearest, (fromBullet(point.m_localPointA) - place).norm());
    }
  }
  for (auto at = before_.lower_bound({row.a, row.b, std::numeric_limits<int>::min()});
       at != before_.end() && std::get<0>(at->first) == row.a && std::get<1>(at->first) == row.b;
       ++at) {
    const bool gone =
        std::find(present.begin(), present.end(), std::get<2>(at->first)) == present.end();
    if (gone && (at->second.place - place).norm() < nearest) return true;
  }
  return false;
}

void EnergyAudit::addJoints() {
  for (int i = 0; i < world_.getNumConstraints(); ++i) {
    btTypedConstraint& joint = *world_.getConstraint(i);
    const btJointFeedback* const applied = joint.getJointFeedback();
    if (!applied || !joint.isEnabled()) continue;
    addJointSide(joint.getRigidBodyA(), applied->m_appliedForceBodyA,
                 applied->m_appliedTorqueBodyA);
    addJointSide(joint.getRigidBodyB(), applied->m_appliedForceBodyB,
                 applied->m_appliedTorqueBodyB);
  }
}

void EnergyAudit::addJointSide(const btRigidBody& body, const btVector3& force,
                               const btVector3& torque) {
  if (!isFree(body) && !body.isKinematicObject()) return;
  const double work = seconds_ * (fromBullet(force).dot(fromBullet(body.getLinearVelocity())) +
                                  fromBullet(torque).dot(fromBullet(body.getAngularVelocity())));
  step_.joints += work;
  if (body.isKinematicObject()) step_.drivers -= work;
}

}  // namespace cloudcontact::program::lab
