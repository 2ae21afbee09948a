// Builds Bullet's world from a scene and reads its state.
#include "scene/world.h"

#include <cloudcontact/bullet/cloud_contact.h>

#include <cmath>
#include <cstring>
#include <iostream>
#include <numbers>
#include <set>

#include "io/errors.h"
#include "scene/bullet_vectors.h"
#include "scene/scene_dispatcher.h"
#include "scene/scene_shapes.h"

namespace cloudcontact::program {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kBears = 10;  // for ExtrapolatingSolver

SurfaceSettings surfacesOf(const SceneDescription& scene, const CommonOptions& options) {
  SurfaceSettings settings;
  settings.friction = options.friction;
  if (options.stiffness)
    settings.pair = KelvinVoigt{*options.stiffness, options.damping.value_or(0)};
  settings.springsForBullet =
      !usesClouds(options.method) && !std::holds_alternative<Rigid>(options.law);
  for (const auto& body : scene.bodies) {
    Surface surface{body.friction, {}};
    // Damping alone is no spring; such a body is rigid.
    if (body.stiffness) surface.material = KelvinVoigt{*body.stiffness, body.damping.value_or(0)};
    settings.bodies.push_back(surface);
  }
  return settings;
}

void checkOptions(const WorldSettings& settings) {
  const auto& o = settings.common;
  checkTogether(o);
  if (o.method == Method::Sdf)
    throw BadInput(
        "--method sdf: Bullet's signed distance fields do not move; use cloud, gjk, gimpact, hacd "
        "or primitive");
  if (o.damping && !o.stiffness)
    throw BadInput("--damping: needs --stiffness beside it, a pair has both or neither");
  if (isViscoelastic(o.law) && (o.stiffness || o.damping))
    throw BadInput("--law: this law has its own stiffness; leave --stiffness and --damping out");
  if (isViscoelastic(o.law) && !usesClouds(o.method))
    throw BadInput("--law: Bullet's own contacts follow Kelvin-Voigt only; use --method cloud");
  if (!usesClouds(o.method) && std::holds_alternative<Foundation>(o.law))
    throw BadInput("--law foundation: Bullet's own contacts have no area; use --method cloud");
}

}  // namespace

struct World::State {
  struct Body {
    SceneBody scene;
    BodyParts parts;
    std::unique_ptr<btRigidBody> rigid;
    Pose fromFrame;  // parts.frame's inverse
  };

  explicit State(const SceneDescription& scene, const WorldSettings& settings);
  void addBodies(const SceneDescription& scene, const WorldSettings& settings);
  void addBody(const SceneBody& body, BodyParts parts, const WorldSettings& settings);
  void addJoint(const SceneJoint& joint);
  void settle(const WorldSettings& settings);
  void noteFrictionless() const;
  void look();
  std::vector<std::pair<int, int>> measuredPairs() const;

  // Declared in the order of their lifetimes in Bullet.
  std::unique_ptr<CloudContact> cloudContact;
  btDefaultCollisionConfiguration configuration;
  SceneDispatcher dispatcher;
  ModelFilter filter;
  btDbvtBroadphase broadphase;
  TimedSolver solver;
  std::vector<Body> bodies;
  std::vector<std::unique_ptr<btTypedConstraint>> joints;
  std::set<std::pair<int, int>> joined;
  btDiscreteDynamicsWorld world;
  ContactMoment moment;
  double latestStep = 0;    // [s]
  std::vector<Pose> poses;  // of all bodies; empty until needed after a step
};

namespace {

std::vector<ModelFilter::Body> modelsOf(const SceneDescription& scene) {
  std::vector<ModelFilter::Body> models;
  for (const auto& body : scene.bodies) models.push_back({body.model, body.selfCollide});
  return models;
}

// --law with --stiffness and --damping; empty: the bodies decide.
std::optional<Law> pairLaw(const CommonOptions& options) {
  const double k = options.stiffness.value_or(0), c = options.damping.value_or(0);
  if (std::holds_alternative<Foundation>(options.law)) return Foundation{k, c};
  if (!std::holds_alternative<KelvinVoigt>(options.law)) return options.law;
  if (!options.stiffness) return {};
  return KelvinVoigt{k, c};
}

std::unique_ptr<CloudContact> makeCloudContact(const CommonOptions& options) {
  CloudContactSettings settings;
  settings.law = pairLaw(options);
  settings.bears = kBears;
  return std::make_unique<CloudContact>(settings);
}

}  // namespace

World::State::State(const SceneDescription& scene, const WorldSettings& settings)
    : cloudContact(makeCloudContact(settings.common)),
      dispatcher(&configuration, surfacesOf(scene, settings.common),
                 usesClouds(settings.common.method) ? settings.common.threads : 1),
      filter(modelsOf(scene)),
      world(&dispatcher, &broadphase, &solver, &configuration) {
  if (usesClouds(settings.common.method))
    cloudContact->attach(dispatcher);
  else
    registerMethod(dispatcher, settings.common.method);
  world.getPairCache()->setOverlapFilterCallback(&filter);
  world.setGravity(toBullet(scene.gravity));
  addBodies(scene, settings);
  for (const auto& joint : scene.joints) addJoint(joint);
  settle(settings);
  dispatcher.onContacts = [this] { look(); };
}

void World::State::addBodies(const SceneDescription& scene, const WorldSettings& settings) {
  SceneShapes shapes(settings.common, settings.voxel, settings.store);
  bodies.reserve(scene.bodies.size());
  for (const auto& body : scene.bodies) addBody(body, shapes.make(body), settings);
  shapes.checkTissues();
}

void World::State::addBody(const SceneBody& body, BodyParts parts, const WorldSettings& settings) {
  btRigidBody::btRigidBodyConstructionInfo info(btScalar(parts.mass), nullptr,
                                                parts.shape.shape.get(), toBullet(parts.inertia));
  info.m_startWorldTransform = toBullet(body.pose * parts.frame);
  info.m_restitution = 0;
  auto rigid = std::make_unique<btRigidBody>(info);
  rigid->setUserIndex(static_cast<int>(bodies.size()));
  if (body.stiffness && usesClouds(settings.common.method))
    rigid->setContactStiffnessAndDamping(btScalar(*body.stiffness),
                                         btScalar(body.damping.value_or(0)));
  if (!body.isStatic) {
    const Vec3 arm = body.pose.orientation * parts.frame.position;
    rigid->setLinearVelocity(toBullet(body.linearVelocity + body.angularVelocity.cross(arm)));
    rigid->setAngularVelocity(toBullet(body.angularVelocity));
    if (!settings.sleep) rigid->setActivationState(DISABLE_DEACTIVATION);
  }
  const Pose fromFrame = parts.frame.inverse();
  bodies.push_back({body, std::move(parts), std::move(rigid), fromFrame});
  world.addRigidBody(bodies.back().rigid.get());
}

void World::State::addJoint(const SceneJoint& joint) {
  // The joint's frame, with z along the axis.
  Pose frame = joint.pose;
  frame.orientation = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), joint.axis);
  // A fixed joint may be anywhere; at the center of mass no lever magnifies the solver's error.
  if (joint.kind == SceneJoint::Kind::Fixed && joint.child >= 0)
    frame.position = (bodies[joint.child].scene.pose * bodies[joint.child].parts.frame).position;
  const auto seenFrom = [&](int body) {
    if (body < 0) return toBullet(frame);
    return toBullet((bodies[body].scene.pose * bodies[body].parts.frame).inverse() * frame);
  };
  btRigidBody& parent =
      joint.parent < 0 ? btTypedConstraint::getFixedBody() : *bodies[joint.parent].rigid;
  btRigidBody& child =
      joint.child < 0 ? btTypedConstraint::getFixedBody() : *bodies[joint.child].rigid;
  const btTransform inParent = seenFrom(joint.parent), inChild = seenFrom(joint.child);
  if (joint.kind == SceneJoint::Kind::Fixed) {
    joints.push_back(std::make_unique<btFixedConstraint>(parent, child, inParent, inChild));
  } else {
    auto hinge = std::make_unique<btHingeConstraint>(parent, child, inParent, inChild, true);
    if (joint.lower && joint.upper) hinge->setLimit(btScalar(*joint.lower), btScalar(*joint.upper));
    joints.push_back(std::move(hinge));
  }
  world.addConstraint(joints.back().get(), true);
  joined.insert(std::minmax(joint.parent, joint.child));
}

void World::State::settle(const WorldSettings& settings) {
  auto& info = world.getSolverInfo();
  info.m_numIterations = settings.iterations;
  bool springs = settings.common.stiffness.has_value();
  for (const auto& body : bodies) springs = springs || body.scene.stiffness;
  // Bullet's own methods keep Bullet's solver and settings, unless stiffness is given.
  solver.extrapolates = usesClouds(settings.common.method);
  if (usesClouds(settings.common.method) || springs) recommendedSettings(world);
  if (!settings.common.friction) noteFrictionless();
}

void World::State::noteFrictionless() const {
  int silent = 0;
  const std::string* first = nullptr;
  for (const auto& body : bodies) {
    if (body.scene.friction || body.scene.isStatic) continue;
    if (silent++ == 0) first = &body.scene.name;
  }
  if (silent > 0)
    std::cerr
        << "cloudcontact: " << silent << (silent == 1 ? " body" : " bodies") << " without <mu> ('"
        << *first
        << "'): they take the other body's; without both there is no friction; --friction sets "
           "all\n";
}

// Energy and counts after the narrow phase.
void World::State::look() {
  moment = {};
  std::set<std::pair<int, int>> touching;
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
    if (manifold.getNumContacts() == 0) continue;
    touching.insert(
        std::minmax(manifold.getBody0()->getUserIndex(), manifold.getBody1()->getUserIndex()));
    moment.contacts += manifold.getNumContacts();
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& p = manifold.getContactPoint(k);
      const double depth = -p.getDistance();
      moment.deepest = std::max(moment.deepest, depth);
      if (depth > 0 && (p.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING))
        moment.energy.spring += 0.5 * p.m_combinedContactStiffness1 * depth * depth;
    }
  }
  moment.pairs = static_cast<int>(touching.size());
  const Vec3 gravity = fromBullet(world.getGravity());
  for (const auto& body : bodies) {
    if (body.scene.isStatic) continue;
    const btTransform& at = body.rigid->getWorldTransform();
    const Vec3 v = fromBullet(body.rigid->getLinearVelocity());
    const Vec3 w = fromBullet(at.getBasis().transpose() * body.rigid->getAngularVelocity());
    moment.energy.kinetic +=
        0.5 * body.parts.mass * v.squaredNorm() + 0.5 * body.parts.inertia.dot(w.cwiseAbs2());
    moment.energy.potential -= body.parts.mass * gravity.dot(fromBullet(at.getOrigin()));
  }
}

std::vector<std::pair<int, int>> World::State::measuredPairs() const {
  std::vector<std::pair<int, int>> pairs;
  const int n = static_cast<int>(bodies.size());
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b) {
      const SceneBody &sa = bodies[a].scene, &sb = bodies[b].scene;
      if (sa.isStatic && sb.isStatic) continue;
      if (sa.model == sb.model && !sa.selfCollide) continue;
      if (joined.count({a, b})) continue;
      pairs.emplace_back(a, b);
    }
  return pairs;
}

namespace {

// The manifold's points are those at the start of the step; a picture needs them at the current
// poses.
Vec3 placeNow(const btManifoldPoint& point, const btCollisionObject& a,
              const btCollisionObject& b) {
  const btVector3 onA = a.getWorldTransform()(point.m_localPointA);
  const btVector3 onB = b.getWorldTransform()(point.m_localPointB);
  return 0.5 * (fromBullet(onA) + fromBullet(onB));
}

// Bullet's normals point from its second body to its first, in the direction of the force on the
// first.
ContactNow contactOf(const btManifoldPoint& point, const btPersistentManifold& manifold,
                     double step) {
  const btVector3 onFirst = point.m_normalWorldOnB * point.m_appliedImpulse +
                            point.m_lateralFrictionDir1 * point.m_appliedImpulseLateral1 +
                            point.m_lateralFrictionDir2 * point.m_appliedImpulseLateral2;
  ContactNow now;
  now.position = placeNow(point, *manifold.getBody0(), *manifold.getBody1());
  now.normal = -fromBullet(point.m_normalWorldOnB);
  now.force = step > 0 ? Vec3(-fromBullet(onFirst) / step) : Vec3::Zero();
  now.depth = -point.getDistance();
  return now;
}

}  // namespace

World::World(const SceneDescription& scene, const WorldSettings& settings) {
  checkOptions(settings);
  state_ = std::make_unique<State>(scene, settings);
}

// Bullet's world must lose its bodies and joints before they are destroyed.
World::~World() {
  for (auto& joint : state_->joints) state_->world.removeConstraint(joint.get());
  for (auto& body : state_->bodies) state_->world.removeRigidBody(body.rigid.get());
}

void World::step(double seconds) {
  state_->world.stepSimulation(btScalar(seconds), 0);
  state_->latestStep = seconds;
  state_->poses.clear();
  for (const auto& body : state_->bodies) {
    const btTransform& at = body.rigid->getWorldTransform();
    const btVector3 sum = at.getOrigin() + at.getBasis()[0] + at.getBasis()[1] +
                          body.rigid->getLinearVelocity() + body.rigid->getAngularVelocity();
    if (!std::isfinite(sum.x() + sum.y() + sum.z()))
      throw WorkFailed("body '" + body.scene.name +
                       "': its state is no longer finite; take a smaller --step");
  }
}

void World::findContacts() {
  state_->world.performDiscreteCollisionDetection();
}

std::size_t World::bodyCount() const {
  return state_->bodies.size();
}
const std::string& World::name(std::size_t body) const {
  return state_->bodies[body].scene.name;
}
bool World::isStatic(std::size_t body) const {
  return state_->bodies[body].scene.isStatic;
}
const ContactMoment& World::moment() const {
  return state_->moment;
}
void World::contacts(ContactsNow& now) const {
  now.patches.clear();
  now.points.clear();
  for (int i = 0; i < state_->dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *state_->dispatcher.getManifoldByIndexInternal(i);
    if (manifold.getNumContacts() == 0) continue;
    const auto points = static_cast<std::size_t>(manifold.getNumContacts());
    now.patches.push_back({manifold.getBody0()->getUserIndex(), manifold.getBody1()->getUserIndex(),
                           now.points.size(), points});
    for (int k = 0; k < manifold.getNumContacts(); ++k)
      now.points.push_back(contactOf(manifold.getContactPoint(k), manifold, state_->latestStep));
  }
}
const DrawnBody& World::drawn(std::size_t body) const {
  return state_->bodies[body].parts.drawn;
}
double World::mass(std::size_t body) const {
  return state_->bodies[body].parts.mass;
}
double World::narrowPhaseSeconds() const {
  return state_->dispatcher.seconds();
}
double World::solverSeconds() const {
  return state_->solver.seconds();
}

const Pose& World::pose(std::size_t body) const {
  if (state_->poses.empty()) {
    for (const State::Body& b : state_->bodies)
      state_->poses.push_back(fromBullet(b.rigid->getWorldTransform()) * b.fromFrame);
  }
  return state_->poses[body];
}

BodyState World::state(std::size_t body) const {
  const State::Body& b = state_->bodies[body];
  BodyState state;
  state.pose = pose(body);
  state.angularVelocity = fromBullet(b.rigid->getAngularVelocity());
  const Vec3 arm = state.pose.position - fromBullet(b.rigid->getWorldTransform().getOrigin());
  state.linearVelocity =
      fromBullet(b.rigid->getLinearVelocity()) + state.angularVelocity.cross(arm);
  state.asleep = !b.scene.isStatic && !b.rigid->isActive();
  return state;
}

double World::penetration() const {
  double deepest = 0;
  for (const auto& [a, b] : state_->measuredPairs())
    deepest = std::max(deepest, program::penetration(state_->bodies[a].parts.measured, pose(a),
                                                     state_->bodies[b].parts.measured, pose(b)));
  return deepest;
}

std::size_t World::probes() const {
  std::size_t count = 0;
  for (const auto& body : state_->bodies) count += probeCount(body.parts.measured);
  return count;
}

std::uint64_t World::hash() const {
  std::uint64_t hash = 14695981039346656037ull;
  const auto mix = [&hash](const btVector3& v) {
    for (int k = 0; k < 3; ++k) {
      unsigned char bytes[sizeof(btScalar)];
      std::memcpy(bytes, &v[k], sizeof bytes);
      for (unsigned char byte : bytes) hash = (hash ^ byte) * 1099511628211ull;
    }
  };
  for (const auto& body : state_->bodies) {
    const btTransform& at = body.rigid->getWorldTransform();
    mix(at.getOrigin());
    for (int row = 0; row < 3; ++row) mix(at.getBasis()[row]);
    mix(body.rigid->getLinearVelocity());
    mix(body.rigid->getAngularVelocity());
  }
  return hash;
}

}  // namespace cloudcontact::program
