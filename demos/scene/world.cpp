// Builds Bullet's world from a scene and reads its state.
#include "scene/world.h"

#include <cloudcontact/bullet/cloud_contact.h>
#include <cloudcontact/bullet/cuttable_body.h>
#include <cloudcontact/bullet/world_cutter.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iostream>
#include <numbers>
#include <set>

#include "io/errors.h"
#include "scene/bullet_vectors.h"
#include "scene/scene_dispatcher.h"
#include "scene/scene_joints.h"
#include "scene/scene_shapes.h"

namespace cloudcontact::program {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kBears = 10;  // for ExtrapolatingSolver
// A static body that can be cut is a heavy one that is put back after each step, so that the solver
// finds the force between it and a tool that nothing moves either.
constexpr double kHeldMass = 1e6;  // in its own masses

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

// Kinetic, and potential in `gravity` [J].
double energyOf(const btRigidBody& body, const Vec3& gravity) {
  if (!(body.getInvMass() > 0)) return 0;
  const double mass = 1 / double(body.getInvMass());
  const btTransform& at = body.getWorldTransform();
  const Vec3 inertia = fromBullet(body.getInvInertiaDiagLocal()).cwiseInverse();
  const Vec3 w = fromBullet(at.getBasis().transpose() * body.getAngularVelocity());
  return 0.5 * mass * fromBullet(body.getLinearVelocity()).squaredNorm() +
         0.5 * inertia.dot(w.cwiseAbs2()) - mass * gravity.dot(fromBullet(at.getOrigin()));
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
    BodyParts parts;                     // frame, mass and inertia follow the cuts
    std::unique_ptr<btRigidBody> own;    // null for a body that can be cut
    std::unique_ptr<CuttableBody> cuts;  // null for others
    btRigidBody* rigid = nullptr;        // of the one or the other
    Pose fromFrame;                      // parts.frame's inverse
    double volume = 0;                   // of a body that can be cut [m^3]
    CutRecord cut = {};
  };

  explicit State(const SceneDescription& scene, const WorldSettings& settings);
  void addBodies(const SceneDescription& scene, const WorldSettings& settings);
  void addBody(const SceneBody& body, BodyParts parts, const WorldSettings& settings);
  void makeRigid(Body& body);
  void makeCuttable(Body& body);
  void enter(Body& body, bool sleeps);
  void addPiece(std::size_t parent, std::unique_ptr<CuttableBody> piece);
  void followCut(Body& body, const Pose& movedFrame);
  void moveJoints(std::size_t body, const Pose& movedFrame);
  void takeOutcome(std::size_t body, CutOutcome outcome);
  void cut(std::size_t body, std::span<const VoxelCut> cuts);
  void vanish(Body& body);
  void startCutting();
  void cutAfter(double step);
  double cuttableEnergy() const;
  void hold();
  void drive(bool moves);
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
  WorldCutter cutter;
  ContactMoment moment;
  double latestStep = 0;  // [s]
  double time = 0;        // [s]
  double cutEnergy = 0;   // Energy::cutAway
  bool hasTools = false;
  std::vector<Pose> poses;  // of all bodies; empty until needed after a step
};

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
  // Bullet takes a kinematic body's velocity from its last two poses, which are rounded.
  world.setInternalTickCallback(
      [](btDynamicsWorld* ticking, btScalar) {
        static_cast<State*>(ticking->getWorldUserInfo())->drive(false);
      },
      this, true);
}

void World::State::addBodies(const SceneDescription& scene, const WorldSettings& settings) {
  SceneShapes shapes(settings.common, settings.voxel, settings.store);
  bodies.reserve(scene.bodies.size());
  for (const auto& body : scene.bodies) addBody(body, shapes.make(body), settings);
  shapes.checkTissues();
  startCutting();
}

void World::State::addBody(const SceneBody& scene, BodyParts parts, const WorldSettings& settings) {
  Body body{scene, std::move(parts), nullptr, nullptr, nullptr, Pose()};
  if (body.parts.matter)
    naming(scene.name, [&] { makeCuttable(body); });
  else
    makeRigid(body);
  body.rigid->setUserIndex(static_cast<int>(bodies.size()));
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

// Made at the origin, where its frame is not rounded by its distance.
void World::State::makeCuttable(Body& body) {
  const CuttableMatter& matter = *body.parts.matter;
  body.cuts =
      std::make_unique<CuttableBody>(matter.cloud, btTransform::getIdentity(), matter.settings);
  body.cuts->shape().setTissues(matter.tissues);
  if (matter.paper) body.cuts->shape().usePaper(*matter.paper);
  body.volume = body.cuts->volume();
  body.rigid = &body.cuts->body();
  body.rigid->setRestitution(0);
  body.parts.frame = matter.place * fromBullet(body.rigid->getWorldTransform());
  followCut(body, Pose());
  body.rigid->setCenterOfMassTransform(toBullet(body.scene.pose * body.parts.frame));
  body.rigid->updateInertiaTensor();
}

void World::State::enter(Body& body, bool sleeps) {
  if (body.scene.drive || (!body.scene.isStatic && !sleeps))
    body.rigid->setActivationState(DISABLE_DEACTIVATION);
  if (!body.cuts) return world.addRigidBody(body.rigid);
  body.cuts->addTo(world);
  if (body.scene.isStatic) body.rigid->setGravity(btVector3(0, 0, 0));
}

// Mass and inertia of a body after a cut that moved its frame by `movedFrame`, in the old one.
void World::State::followCut(Body& body, const Pose& movedFrame) {
  body.parts.frame = body.parts.frame * movedFrame;
  body.fromFrame = body.parts.frame.inverse();
  body.volume = body.cuts->volume();
  const double mass = 1 / double(body.rigid->getInvMass());
  const Vec3 inertia = fromBullet(body.rigid->getInvInertiaDiagLocal()).cwiseInverse();
  if (body.scene.isStatic) {
    body.rigid->setMassProps(btScalar(kHeldMass * mass), toBullet(Vec3(kHeldMass * inertia)));
    body.rigid->updateInertiaTensor();
  } else {
    body.parts.mass = mass;
    body.parts.inertia = inertia;
  }
}

// Puts static bodies that can be cut back to their places.
void World::State::hold() {
  for (auto& body : bodies) {
    if (!body.cuts || !body.scene.isStatic || body.cut.gone) continue;
    body.rigid->setLinearVelocity(btVector3(0, 0, 0));
    body.rigid->setAngularVelocity(btVector3(0, 0, 0));
    body.rigid->setCenterOfMassTransform(toBullet(body.scene.pose * body.parts.frame));
  }
}

// A piece has its body's frame, materials and surface, but touches everything.
void World::State::addPiece(std::size_t parent, std::unique_ptr<CuttableBody> piece) {
  Body body{bodies[parent].scene, BodyParts(), nullptr, std::move(piece), nullptr, Pose()};
  const Body& from = bodies[parent];
  body.scene.name += " piece " + std::to_string(from.cut.pieces);
  body.scene.isStatic = false;
  for (const Body& other : bodies) body.scene.model = std::max(body.scene.model, other.scene.model);
  ++body.scene.model;
  body.parts.isMeasured = false;
  body.parts.matter = from.parts.matter;
  const CuttableMatter& matter = *from.parts.matter;
  body.cuts->shape().setTissues(matter.tissues);
  if (matter.paper) body.cuts->shape().usePaper(*matter.paper);
  if (hasTools) cutter.addBody(*body.cuts, matter.tissues);
  body.rigid = &body.cuts->body();
  body.rigid->setGravity(world.getGravity());  // a body that is held has none
  body.rigid->setUserIndex(static_cast<int>(bodies.size()));
  body.parts.frame = body.parts.matter->place * (fromBullet(body.cuts->cloudPlace()).inverse() *
                                                 fromBullet(body.rigid->getWorldTransform()));
  followCut(body, Pose());
  dispatcher.add(dispatcher.surfaces().bodies[parent]);
  filter.add({body.scene.model, true, true, false, true});
  bodies.push_back(std::move(body));
}

// Constraint frames lie in the frame of the rigid body, which a cut moves.
void World::State::moveJoints(std::size_t body, const Pose& movedFrame) {
  const btTransform back = toBullet(movedFrame.inverse());
  for (const auto& joint : joints) moveJoint(*joint, *bodies[body].rigid, back);
}

void World::State::takeOutcome(std::size_t index, CutOutcome outcome) {
  double lost = bodies[index].volume;
  for (auto& piece : outcome.fallen) {
    lost -= piece->volume();
    ++bodies[index].cut.pieces;
    addPiece(index, std::move(piece));
  }
  Body& body = bodies[index];
  if (outcome.gone) {
    vanish(body);
  } else {
    followCut(body, outcome.frame);
    moveJoints(index, outcome.frame);
    lost -= body.volume;
  }
  body.cut.mass += outcome.cutAway.mass;
  body.cut.volume += lost;
  poses.clear();
}

// Nothing is left of a body: it is out of its world, and no joint holds it.
void World::State::vanish(Body& body) {
  body.cut.gone = true;
  body.volume = body.parts.mass = 0;
  const auto holds = [&](const auto& joint) {
    return &joint->getRigidBodyA() == body.rigid || &joint->getRigidBodyB() == body.rigid;
  };
  for (auto& joint : joints)
    if (holds(joint)) world.removeConstraint(joint.get());
  std::erase_if(joints, holds);
}

double World::State::cuttableEnergy() const {
  const Vec3 gravity = fromBullet(world.getGravity());
  double sum = 0;
  for (const auto& body : bodies)
    if (body.cuts && body.scene.isFree() && !body.cut.gone) sum += energyOf(*body.rigid, gravity);
  return sum;
}

void World::State::cut(std::size_t index, std::span<const VoxelCut> cuts) {
  if (!bodies[index].cuts || bodies[index].cut.gone) return;
  const double before = cuttableEnergy();
  takeOutcome(index, bodies[index].cuts->cut(cuts));
  cutEnergy += before - cuttableEnergy();
}

void World::State::startCutting() {
  for (const auto& body : bodies)
    for (const SceneTool& tool : body.parts.tools) {
      naming(body.scene.name, [&] { cutter.addTool(*body.rigid, tool.detection, tool.cutter); });
      hasTools = true;
    }
  if (!hasTools) return;
  for (const auto& body : bodies)
    if (body.cuts)
      naming(body.scene.name, [&] { cutter.addBody(*body.cuts, body.parts.matter->tissues); });
}

void World::State::cutAfter(double step) {
  if (!hasTools) return;
  const double before = cuttableEnergy();
  std::vector<WorldCut> done = cutter.after(step);
  if (done.empty()) return;
  for (WorldCut& cut : done) {
    const auto found = std::find_if(bodies.begin(), bodies.end(),
                                    [&](const Body& body) { return body.cuts.get() == cut.body; });
    takeOutcome(static_cast<std::size_t>(found - bodies.begin()), std::move(cut.outcome));
  }
  cutEnergy += before - cuttableEnergy();
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
  moment.energy.cutAway = cutEnergy;
  for (const auto& body : bodies) {
    if (!body.scene.isFree() || body.cut.gone) continue;
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
