// A world of nuts in a box: see heap.h.
#include "heap.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>

namespace cloudcontact {

namespace {

constexpr int kLayers = 10;
constexpr double kStep = 1.0 / 240, kFriction = 0.4;

using Clock = std::chrono::steady_clock;

double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

btScalar s(double x) {
  return static_cast<btScalar>(x);
}

}  // namespace

void Heap::TimedDispatcher::dispatchAllCollisionPairs(btOverlappingPairCache* pairs,
                                                      const btDispatcherInfo& info,
                                                      btDispatcher* dispatcher) {
  const auto start = Clock::now();
  CloudDispatcher::dispatchAllCollisionPairs(pairs, info, dispatcher);
  seconds += since(start);
}

Heap::Heap(const HeapSettings& settings)
    : contact_(settings.contact),
      dispatcher_(&configuration_, CloudDispatcherSettings{.threads = settings.threads,
                                                           .backend = settings.backend,
                                                           .timing = settings.timing}) {
  // Bullet enlarges boxes by 2 cm and by another 5 cm, whatever the size of the bodies.
  gContactBreakingThreshold = s(settings.voxel);
  gDbvtMargin = s(settings.voxel);
  if (settings.clouds) {
    contact_.attach(dispatcher_);
    recommendedSettings(world_);
  }
  solver_.newton = settings.newton;
  // Islands one by one: the extrapolation of one must not wait for another.
  if (settings.newton) world_.getSolverInfo().m_minimumSolverBatchSize = 1;
  world_.setGravity({0, 0, s(settings.floats ? 0 : -9.81)});
  reach_ = std::hypot(settings.across, settings.height) / 2;
  if (!settings.places.empty()) {
    if (settings.slab > 0)
      addSlab(settings.slab);
    else if (!settings.floats)
      addWall({0, 0, 1}, 0);
    for (const btTransform& place : settings.places) addBody(settings, place);
  } else {
    settings.poured ? pour(settings) : lay(settings);
  }
}

Heap::~Heap() {
  for (auto* bodies : {&bodies_, &walls_})
    for (auto& body : *bodies) world_.removeRigidBody(body.get());
}

void Heap::addWall(const btVector3& normal, double offset) {
  addGround(std::make_shared<btStaticPlaneShape>(normal, s(offset)), btTransform::getIdentity());
}

// Its box does not reach the upper bodies, as a plane's does.
void Heap::addSlab(double edge) {
  const double thick = 2 * reach_;
  addGround(std::make_shared<btBoxShape>(btVector3(s(edge / 2), s(edge / 2), s(thick / 2))),
            btTransform(btQuaternion::getIdentity(), btVector3(0, 0, s(-thick / 2))));
}

void Heap::addGround(std::shared_ptr<btCollisionShape> shape, const btTransform& place) {
  planes_.push_back(std::move(shape));
  btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, planes_.back().get());
  info.m_startWorldTransform = place;
  info.m_friction = s(kFriction);
  walls_.push_back(std::make_unique<btRigidBody>(info));
  world_.addRigidBody(walls_.back().get());
}

void Heap::addBody(const HeapSettings& settings, const btTransform& place) {
  const std::shared_ptr<btCollisionShape> shape = settings.shape();
  btVector3 inertia;
  shape->calculateLocalInertia(s(settings.mass), inertia);
  btRigidBody::btRigidBodyConstructionInfo info(s(settings.mass), nullptr, shape.get(), inertia);
  info.m_startWorldTransform = place;
  info.m_friction = s(kFriction);
  shapes_.push_back(shape);
  bodies_.push_back(std::make_unique<btRigidBody>(info));
  bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
  bodies_.back()->setUserIndex(static_cast<int>(bodies_.size()) - 1);
  world_.addRigidBody(bodies_.back().get());
}

// Square layers, every other one shifted by 0.4 bodies, each body rotated about z.
void Heap::lay(const HeapSettings& settings) {
  const int side = static_cast<int>(std::ceil(std::sqrt(double(settings.bodies) / kLayers)));
  const double pitch = settings.across + settings.voxel, rise = settings.height;
  addWall({0, 0, 1}, 0);
  for (const double sign : {1.0, -1.0}) {
    const double at = sign > 0 ? -0.6 * pitch : -pitch * side;
    addWall({s(sign), 0, 0}, at);
    addWall({0, s(sign), 0}, at);
  }
  for (int i = 0; i < settings.bodies; ++i) {
    const int layer = i / (side * side), column = i / side % side, row = i % side;
    const double shift = layer % 2 ? 0.4 : 0;
    const double angle = 2.4 * i;  // the golden angle: no two alike
    addBody(settings, btTransform(btQuaternion({0, 0, 1}, s(angle)),
                                  {s(pitch * (row + shift)), s(pitch * (column + shift)),
                                   s(rise * (layer + 0.5) - 0.1 * settings.voxel * (layer + 1))}));
  }
}

// A cube of bodies that do not touch, over a box of the same width.
void Heap::pour(const HeapSettings& settings) {
  const int side = static_cast<int>(std::ceil(std::cbrt(double(settings.bodies))));
  const double pitch = 2 * reach_ + settings.voxel;
  addWall({0, 0, 1}, 0);
  for (const double sign : {1.0, -1.0}) {
    const double at = sign > 0 ? 0 : -pitch * side;
    addWall({s(sign), 0, 0}, at);
    addWall({0, s(sign), 0}, at);
  }
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < settings.bodies; ++i) {
    const auto at = [&](int k) { return s(pitch * (k + 0.5)); };
    btQuaternion rotation(s(normal(random)), s(normal(random)), s(normal(random)),
                          s(normal(random)));
    rotation.normalize();
    addBody(settings,
            btTransform(rotation, {at(i % side), at(i / side % side), at(i / side / side)}));
  }
}

double Heap::step() {
  const auto start = Clock::now();
  world_.stepSimulation(s(kStep), 0);
  return since(start);
}

Pose Heap::pose(int body) const {
  const btTransform& at = bodies_[static_cast<std::size_t>(body)]->getWorldTransform();
  const btQuaternion q = at.getRotation();
  Pose pose;
  pose.position = Vec3(at.getOrigin().x(), at.getOrigin().y(), at.getOrigin().z());
  pose.orientation = Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).normalized();
  return pose;
}

std::vector<std::pair<int, int>> Heap::near() {
  std::vector<std::pair<int, int>> found;
  const btBroadphasePairArray& pairs =
      broadphase_.getOverlappingPairCache()->getOverlappingPairArray();
  for (int i = 0; i < pairs.size(); ++i) {
    const auto numberOf = [](const btBroadphaseProxy* proxy) {
      return static_cast<const btCollisionObject*>(proxy->m_clientObject)->getUserIndex();
    };
    const int a = numberOf(pairs[i].m_pProxy0), b = numberOf(pairs[i].m_pProxy1);
    if (a >= 0 && b >= 0) found.emplace_back(a, b);
  }
  return found;
}

void Heap::rest(const Heap& other) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    bodies_[i]->setWorldTransform(other.bodies_[i]->getWorldTransform());
    bodies_[i]->setInterpolationWorldTransform(other.bodies_[i]->getWorldTransform());
    bodies_[i]->setLinearVelocity({0, 0, 0});
    bodies_[i]->setAngularVelocity({0, 0, 0});
  }
}

double Heap::energy() const {
  double sum = 0;
  for (const auto& body : bodies_) {
    const double mass = 1 / double(body->getInvMass());
    sum += mass * (double(body->getLinearVelocity().length2()) / 2 +
                   9.81 * double(body->getWorldTransform().getOrigin().z()));
    const btVector3 spin = body->getAngularVelocity() * body->getWorldTransform().getBasis();
    const btVector3 inverse = body->getInvInertiaDiagLocal();
    for (int axis = 0; axis < 3; ++axis)
      sum += double(spin[axis]) * double(spin[axis]) / 2 / double(inverse[axis]);
  }
  return sum;
}

double Heap::fastest() const {
  double most = 0;
  for (const auto& body : bodies_)
    most = std::max(most, double(body->getLinearVelocity().length()) +
                              reach_ * double(body->getAngularVelocity().length()));
  return most;
}

void Heap::count(HeapRow& row) {
  std::vector<std::pair<const void*, const void*>> touching;
  for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *dispatcher_.getManifoldByIndexInternal(i);
    if (manifold.getNumContacts() == 0) continue;
    touching.emplace_back(manifold.getBody0(), manifold.getBody1());
    row.contacts += manifold.getNumContacts();
    for (int k = 0; k < manifold.getNumContacts(); ++k)
      row.deepest = std::max(row.deepest, -double(manifold.getContactPoint(k).getDistance()));
  }
  std::sort(touching.begin(), touching.end());
  row.pairs += double(std::unique(touching.begin(), touching.end()) - touching.begin());
  row.overlaps += broadphase_.getOverlappingPairCache()->getNumOverlappingPairs();
}

HeapRow Heap::run(int settle, int measured) {
  for (int i = 0; i < settle; ++i) world_.stepSimulation(s(kStep), 0);
  HeapRow row;
  row.bodies = static_cast<int>(shapes_.size());
  dispatcher_.seconds = 0;
  const auto start = Clock::now();
  for (int i = 0; i < measured; ++i) world_.stepSimulation(s(kStep), 0);
  row.stepSeconds = since(start) / measured;
  row.narrowSeconds = dispatcher_.seconds / measured;
  count(row);
  return row;
}

}  // namespace cloudcontact
