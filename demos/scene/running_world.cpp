// Builds Bullet's world from a scene and steps it (world.h).
#include "scene/running_world.h"

#include <cmath>
#include <iostream>

#include "io/errors.h"
#include "scene/bullet_vectors.h"
#include "scene/scene_check.h"
#include "scene/world_setup.h"

namespace cloudcontact::program {
namespace {

// The pose of a driven body that was at `start`.
Pose drivenPose(const SceneDrive& drive, const Pose& start, double seconds) {
  Pose at = start * drive.place;
  at.position += seconds * drive.linear;
  if (const double speed = drive.angular.norm(); speed > 0)
    at.orientation = Eigen::AngleAxisd(speed * seconds, drive.angular / speed) * at.orientation;
  return at * drive.place.inverse();
}

// Building fields takes longest, on the CPU.
CommonOptions onCpu(CommonOptions options) {
  options.backend = Backend::Cpu;
  return options;
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
}

// Apart from the constructor: where it throws, bodies must leave the world as at its end.
void World::State::fill(const SceneDescription& scene, const WorldSettings& settings) {
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
  SceneShapes shapes(options, settings.voxel, settings.store, traitsOf(scene));
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
  // Bullet multiplies the two. What nothing moves leaves it to the other body.
  info.m_restitution = btScalar(body.scene.restitution.value_or(body.scene.isFree() ? 0 : 1));
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
    const Pose pose = drivenPose(drive, body.scene.pose, time - body.driveFrom);
    const Pose rigid = pose * body.parts.frame;
    if (moves) body.rigid->setWorldTransform(toBullet(rigid));
    const Vec3 arm = rigid.position - (pose * drive.place).position;
    body.rigid->setLinearVelocity(toBullet(drive.linear + drive.angular.cross(arm)));
    body.rigid->setAngularVelocity(toBullet(drive.angular));
  }
}

void World::State::settle(const WorldSettings& settings) {
  auto& info = world.getSolverInfo();
  if (settings.iterations) {
    info.m_numIterations = *settings.iterations;
    solver.mostSweeps = 0;
  }
  bool springs = settings.common.stiffness.has_value();
  for (const auto& body : bodies) springs = springs || body.scene.stiffness;
  // Bullet's own methods keep Bullet's solver and settings, unless stiffness is given.
  solver.newton = usesClouds(settings.common.method);
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

World::World(const SceneDescription& scene, const WorldSettings& settings) {
  checkOptions(settings);
  validate(settings);
  validate(scene);
  state_ = std::make_unique<State>(scene, settings);
  state_->fill(scene, settings);
}

World::~World() = default;

// Bullet's world must lose its bodies and joints before they are destroyed.
World::State::~State() {
  for (auto& joint : joints) world.removeConstraint(joint.rows.get());
  for (auto& body : bodies) {
    if (body.cuts)
      body.cuts->leaveWorld();
    else if (body.soft)
      body.soft->leaveWorld();
    else
      world.removeRigidBody(body.rigid);
  }
}

namespace {

btScalar thinnestOf(const btCollisionShape& shape) {
  btVector3 low, high;
  shape.getAabb(btTransform::getIdentity(), low, high);
  const btVector3 size = high - low;
  return size[size.minAxis()];
}

}  // namespace

// A body that flies, and would move by half of its thinnest side in a step, may pass what it should
// hit: it is swept. One that touches or nearly touches something is not: it sees what is around
// it there, and a sweep would stop a peg at the first wall of its hole.
void World::State::sweepFlying() {
  if (!solver.newton) return;  // Bullet's own methods keep Bullet's settings
  std::vector<char> meets(bodies.size(), 0);
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
    if (manifold.getNumContacts() == 0) continue;
    for (const btCollisionObject* object : {manifold.getBody0(), manifold.getBody1()})
      if (const auto index = std::size_t(object->getUserIndex()); index < meets.size())
        meets[index] = 1;
  }
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    btRigidBody& body = *bodies[i].rigid;
    if (!bodies[i].scene.isFree() || bodies[i].soft) continue;
    body.setCcdMotionThreshold(meets[i] ? 0 : thinnestOf(*body.getCollisionShape()) / 2);
  }
}

void World::step(double seconds) {
  state_->sweepFlying();
  state_->pull();
  state_->load();
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
void World::cut(std::size_t body, std::span<const VoxelCut> cuts) {
  state_->cut(body, cuts);
}

}  // namespace cloudcontact::program
