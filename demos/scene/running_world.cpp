// Builds Bullet's world from a scene, steps it and reads its state (world.h).
#include "scene/running_world.h"

#include <cloudcontact/bullet/shape_report.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iostream>
#include <set>

#include "io/errors.h"
#include "scene/bullet_vectors.h"
#include "scene/scene_joints.h"

namespace cloudcontact::program {
namespace {

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

// The pose of a driven body that was at `start`.
Pose drivenPose(const SceneDrive& drive, const Pose& start, double seconds) {
  Pose at = start * drive.place;
  at.position += seconds * drive.linear;
  if (const double speed = drive.angular.norm(); speed > 0)
    at.orientation = Eigen::AngleAxisd(speed * seconds, drive.angular / speed) * at.orientation;
  return at * drive.place.inverse();
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

namespace {

bool hasTool(const SceneBody& body) {
  return std::any_of(body.collisions.begin(), body.collisions.end(),
                     [](const SceneCollision& c) { return c.cutter.has_value(); });
}

std::vector<ModelFilter::Body> modelsOf(const SceneDescription& scene) {
  std::vector<ModelFilter::Body> models;
  for (const auto& body : scene.bodies)
    models.push_back({body.model, body.selfCollide, body.isFree(), hasTool(body),
                      !body.collisions.empty() && body.collisions.front().isCuttable});
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

// With a device if --backend asks for one and there is one.
SceneDispatcher makeDispatcher(btCollisionConfiguration* configuration,
                               const SceneDescription& scene, const CommonOptions& options) {
  CloudDispatcherSettings clouds{.threads = options.threads, .backend = options.backend};
  if (!usesClouds(options.method)) {
    clouds = {.threads = 1};
    if (options.backend == Backend::OpenCl)
      reportCpuFallback("the method '" + std::string(nameOf(options.method)) + "' has no kernels");
  }
  try {
    return {configuration, surfacesOf(scene, options), clouds};
  } catch (const std::runtime_error& why) {
    if (clouds.backend == Backend::Cpu) throw;
    reportCpuFallback(why.what());
  }
  clouds.backend = Backend::Cpu;
  return {configuration, surfacesOf(scene, options), clouds};
}

// Building fields takes longest, on the CPU.
CommonOptions onCpu(CommonOptions options) {
  options.backend = Backend::Cpu;
  return options;
}

std::unique_ptr<CloudContact> makeCloudContact(const CommonOptions& options) {
  CloudContactSettings settings;
  settings.law = pairLaw(options);
  settings.bears = kBears;
  if (options.reuse) settings.reuseMotion = *options.reuse;
  settings.keepReports = options.explain;
  return std::make_unique<CloudContact>(settings);
}

}  // namespace

World::State::State(const SceneDescription& scene, const WorldSettings& settings)
    : cloudContact(makeCloudContact(settings.common)),
      dispatcher(makeDispatcher(&configuration, scene, settings.common)),
      filter(modelsOf(scene)),
      world(&dispatcher, &broadphase, &solver, &configuration) {
  if (usesClouds(settings.common.method))
    cloudContact->attach(dispatcher);
  else
    registerMethod(dispatcher, settings.common.method);
  world.getPairCache()->setOverlapFilterCallback(&filter);
  world.setGravity(toBullet(scene.gravity));
  world.getWorldInfo().m_gravity = toBullet(scene.gravity);
  addBodies(scene, settings);
  for (const auto& joint : scene.joints) addJoint(joint);
  settle(settings);
  measureSoft();
  dispatcher.onContacts = [this] { look(); };
  // Bullet takes a kinematic body's velocity from its last two poses, which are rounded.
  world.setInternalTickCallback(
      [](btDynamicsWorld* ticking, btScalar) {
        static_cast<State*>(ticking->getWorldUserInfo())->drive(false);
      },
      this, true);
}

void World::State::addBodies(const SceneDescription& scene, const WorldSettings& settings) {
  const CommonOptions options = onCpu(settings.common);
  SceneShapes shapes(options, settings.voxel, settings.store);
  bodies.reserve(scene.bodies.size());
  for (const auto& body : scene.bodies) addBody(body, shapes.make(body), settings);
  shapes.checkTissues();
  startCutting();
}

void World::State::addBody(const SceneBody& scene, BodyParts parts, const WorldSettings& settings) {
  Body body{scene, std::move(parts), nullptr, nullptr, nullptr, Pose()};
  if (body.parts.matter)
    naming(scene.name, [&] { makeCuttable(body); });
  else if (body.parts.soft)
    naming(scene.name, [&] { makeSoft(body); });
  else
    makeRigid(body);
  body.rigid->setUserIndex(static_cast<int>(bodies.size()));
  if (body.soft) body.soft->body().setUserIndex(static_cast<int>(bodies.size()));
  if (scene.stiffness && usesClouds(settings.common.method))
    body.rigid->setContactStiffnessAndDamping(btScalar(*scene.stiffness),
                                              btScalar(scene.damping.value_or(0)));
  if (scene.isFree()) {
    const Vec3 arm = scene.pose.orientation * body.parts.frame.position;
    body.rigid->setLinearVelocity(
        toBullet(scene.linearVelocity + scene.angularVelocity.cross(arm)));
    body.rigid->setAngularVelocity(toBullet(scene.angularVelocity));
  }
  body.fromFrame = body.parts.frame.inverse();
  bodies.push_back(std::move(body));
  enter(bodies.back(), settings.sleep);
}

void World::State::makeRigid(Body& body) {
  const BodyParts& parts = body.parts;
  btRigidBody::btRigidBodyConstructionInfo info(btScalar(parts.mass), nullptr,
                                                parts.shape.shape.get(), toBullet(parts.inertia));
  info.m_startWorldTransform = toBullet(body.scene.pose * parts.frame);
  info.m_restitution = 0;
  body.own = std::make_unique<btRigidBody>(info);
  body.rigid = body.own.get();
  if (body.scene.drive)
    body.rigid->setCollisionFlags(
        (body.rigid->getCollisionFlags() & ~btCollisionObject::CF_STATIC_OBJECT) |
        btCollisionObject::CF_KINEMATIC_OBJECT);
}

void World::State::enter(Body& body, bool sleeps) {
  if (body.soft) return body.soft->addTo(world);
  if (body.scene.drive || (!body.scene.isStatic && !sleeps))
    body.rigid->setActivationState(DISABLE_DEACTIVATION);
  if (!body.cuts) return world.addRigidBody(body.rigid);
  body.cuts->addTo(world);
  if (body.scene.isStatic) body.rigid->setGravity(btVector3(0, 0, 0));
}

// Gives driven bodies their velocities; `moves`: and puts them where they are now.
void World::State::drive(bool moves) {
  for (auto& body : bodies) {
    if (!body.scene.drive) continue;
    const SceneDrive& drive = *body.scene.drive;
    const Pose pose = drivenPose(drive, body.scene.pose, time);
    const Pose rigid = pose * body.parts.frame;
    if (moves) body.rigid->setWorldTransform(toBullet(rigid));
    const Vec3 arm = rigid.position - (pose * drive.place).position;
    body.rigid->setLinearVelocity(toBullet(drive.linear + drive.angular.cross(arm)));
    body.rigid->setAngularVelocity(toBullet(drive.angular));
  }
}

void World::State::addJoint(const SceneJoint& joint) {
  for (const int body : {joint.parent, joint.child})
    if (body >= 0 && bodies[body].soft)
      throw BadInput("joint '" + joint.name + "': body '" + bodies[body].scene.name +
                     "' deforms; hold its sides by <cloudcontact:soft held=\"...\"> instead");
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
  joints.push_back(makeJoint(joint, parent, child, inParent, inChild));
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
  noteSoftOnPlanes();
  const bool anySoft = std::any_of(bodies.begin(), bodies.end(),
                                   [](const Body& body) { return body.soft != nullptr; });
  for (auto& body : bodies) {
    if (body.soft)
      body.soft->body().m_cfg.kDF =
          btScalar(settings.common.friction.value_or(body.scene.friction.value_or(0)));
    else if (anySoft)
      body.rigid->setFriction(1);  // the soft body's is then the pair's
  }
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
  ContactsNow soft;
  softContacts(soft);
  for (const PatchNow& patch : soft.patches) {
    touching.insert(std::minmax(patch.a, patch.b));
    for (const ContactNow& p : soft.of(patch)) moment.deepest = std::max(moment.deepest, p.depth);
  }
  moment.contacts += static_cast<int>(soft.points.size());
  moment.pairs = static_cast<int>(touching.size());
  const Vec3 gravity = fromBullet(world.getGravity());
  moment.energy.kinetic = softEnergy.kinetic;
  moment.energy.potential = softEnergy.potential;
  moment.energy.elastic = softEnergy.elastic;
  moment.energy.cutAway = cutEnergy;
  for (const auto& body : bodies) {
    if (!body.scene.isFree() || body.cut.gone || body.soft) continue;
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
      if (!sa.isFree() && !sb.isFree()) continue;
      if (!bodies[a].parts.isMeasured || !bodies[b].parts.isMeasured) continue;
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
  for (auto& body : state_->bodies) {
    if (body.cuts)
      body.cuts->leaveWorld();
    else if (body.soft)
      body.soft->leaveWorld();
    else
      state_->world.removeRigidBody(body.rigid);
  }
}

void World::step(double seconds) {
  state_->world.stepSimulation(btScalar(seconds), 0);
  state_->latestStep = seconds;
  state_->time += seconds;
  state_->drive(true);
  state_->hold();
  state_->cutAfter(seconds);
  state_->followSoft();
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
std::vector<KnownShape> World::knownShapes() const {
  std::vector<KnownShape> known;
  for (const ShapeReport& report : shapeReport(state_->world))
    if (const RecognizedShape* shape = report.shape->recognized())
      known.push_back({static_cast<std::size_t>(report.object->getUserIndex()),
                       shapeName(shape->placed.solid), shape->error});
  return known;
}
std::vector<PairUse> World::pairs() const {
  std::vector<PairUse> pairs;
  if (!state_->cloudContact) return pairs;
  for (const PairReport& report : state_->cloudContact->pairs())
    pairs.push_back({static_cast<std::size_t>(report.a->getUserIndex()),
                     static_cast<std::size_t>(report.b->getUserIndex()), report});
  return pairs;
}
bool World::isCuttable(std::size_t body) const {
  return state_->bodies[body].cuts != nullptr;
}
const Cloud& World::matter(std::size_t body) const {
  return state_->bodies[body].cuts->cloud();
}
const Pose& World::matterPlace(std::size_t body) const {
  return state_->bodies[body].parts.matter->place;
}
const CutRecord& World::cutOf(std::size_t body) const {
  return state_->bodies[body].cut;
}
void World::cut(std::size_t body, std::span<const VoxelCut> cuts) {
  state_->cut(body, cuts);
}
bool World::isMeasured(std::size_t body) const {
  return state_->bodies[body].parts.isMeasured;
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
  state_->softContacts(now);
}
const DrawnBody& World::drawn(std::size_t body) const {
  return state_->bodies[body].parts.drawn;
}
double World::mass(std::size_t body) const {
  return state_->bodies[body].parts.mass;
}
DeviceUse World::deviceUse() const {
  const CloudDispatcherStatistics s = state_->dispatcher.statistics();
  return {state_->dispatcher.device(),
          s.deviceFailure,
          s.deviceSteps,
          CloudDispatcherSettings{}.leastForDevice,
          s.device.onDevice,
          s.device.onCpu};
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
    if (!body.soft) continue;
    const auto& nodes = body.soft->body().m_nodes;
    for (int i = 0; i < nodes.size(); ++i) {
      mix(nodes[i].m_x);
      mix(nodes[i].m_v);
    }
  }
  return hash;
}

}  // namespace cloudcontact::program
