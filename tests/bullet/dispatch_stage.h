// A world with the dispatcher of the test's choice, and a hash of its state after a step.
#pragma once

// First: Bullet's soft bodies declare a global named seed.
#include "bullet/bullet_world.h"
#include "mesh/plain_nut.h"

#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <cloudcontact/bullet/cloud_dispatcher.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

namespace cloudcontact::testing {

class Hash {
 public:
  template <typename Number>
  void add(const Number& value) {
    unsigned char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    for (const unsigned char byte : bytes) hash_ = (hash_ ^ byte) * 1099511628211ull;
  }
  void add(const btVector3& v) {  // without its unused fourth number
    for (int i = 0; i < 3; ++i) add(v[i]);
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 14695981039346656037ull;
};

inline void addTo(Hash& hash, const btManifoldPoint& p) {
  for (const btVector3* v :
       {&p.m_localPointA, &p.m_localPointB, &p.m_positionWorldOnA, &p.m_positionWorldOnB,
        &p.m_normalWorldOnB, &p.m_lateralFrictionDir1, &p.m_lateralFrictionDir2})
    hash.add(*v);
  for (const btScalar x :
       {p.m_distance1, p.m_combinedFriction, p.m_combinedRestitution, p.m_appliedImpulse,
        p.m_appliedImpulseLateral1, p.m_appliedImpulseLateral2, p.m_contactMotion1,
        p.m_contactMotion2, p.m_combinedContactStiffness1, p.m_combinedContactDamping1})
    hash.add(x);
  for (const int x :
       {p.m_partId0, p.m_partId1, p.m_index0, p.m_index1, p.m_contactPointFlags, p.m_lifeTime})
    hash.add(x);
}

class Stage {
 public:
  // 0 threads: Bullet's own dispatcher.
  explicit Stage(int threads, const CloudContactSettings& settings = {})
      : Stage(CloudDispatcherSettings{.threads = threads}, settings, threads > 0) {}
  explicit Stage(const CloudDispatcherSettings& dispatch, const CloudContactSettings& settings = {},
                 bool own = true)
      : clouds(settings), dispatcher(own ? make(dispatch) : make()) {
    clouds.attach(*dispatcher);
    recommendedSettings(world);
    world.setGravity({0, 0, btScalar(-9.81)});
    world.getWorldInfo().m_gravity = world.getGravity();
  }
  ~Stage() {
    for (auto& soft : softs_) world.removeSoftBody(soft.get());
    while (!bodies.empty()) removeLast();
  }

  btRigidBody& add(std::unique_ptr<btCollisionShape> shape, double mass, const btTransform& place) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, shape.get(), inertia);
    info.m_startWorldTransform = place;
    info.m_friction = btScalar(0.4);
    shapes_.push_back(std::move(shape));
    bodies.push_back(std::make_unique<btRigidBody>(info));
    if (mass > 0) bodies.back()->setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(bodies.back().get());
    return *bodies.back();
  }
  btRigidBody& addGround() {
    return add(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0), 0, at({0, 0, 0}));
  }
  void removeLast() {
    world.removeRigidBody(bodies.back().get());
    bodies.pop_back();
  }
  btSoftBody& keep(btSoftBody* made, double mass) {
    softs_.emplace_back(made);
    made->setTotalMass(btScalar(mass), true);
    made->getCollisionShape()->setMargin(btScalar(1e-3));
    world.addSoftBody(made);
    return *made;
  }
  // The same shape again, for compounds.
  template <typename Shape>
  Shape* own(std::unique_ptr<Shape> shape) {
    Shape* const made = shape.get();
    shapes_.push_back(std::move(shape));
    return made;
  }

  void step() { world.stepSimulation(btScalar(1) / 240, 0); }

  // A hash of all manifolds in order, with bodies and points, and of all objects' motion.
  std::uint64_t hash() const {
    Hash sum;
    const auto& objects = world.getCollisionObjectArray();
    for (int i = 0; i < dispatcher->getNumManifolds(); ++i) {
      const btPersistentManifold& manifold = *dispatcher->getManifoldByIndexInternal(i);
      sum.add(manifold.getBody0()->getWorldArrayIndex());
      sum.add(manifold.getBody1()->getWorldArrayIndex());
      for (int k = 0; k < manifold.getNumContacts(); ++k) addTo(sum, manifold.getContactPoint(k));
    }
    for (int i = 0; i < objects.size(); ++i) {
      const btRigidBody* const body = btRigidBody::upcast(objects[i]);
      sum.add(objects[i]->getWorldTransform().getOrigin());
      if (body) sum.add(body->getLinearVelocity());
      if (body) sum.add(body->getAngularVelocity());
    }
    for (const auto& soft : softs_)
      for (int i = 0; i < soft->m_nodes.size(); ++i) sum.add(soft->m_nodes[i].m_x);
    return sum.value();
  }
  // The fraction of results searched ahead that Bullet used; NaN if there are none.
  double hitRate() const {
    const auto* own = dynamic_cast<const CloudDispatcher*>(dispatcher.get());
    const CloudDispatcherStatistics s = own ? own->statistics() : CloudDispatcherStatistics{};
    return double(s.taken) / double(s.ahead);
  }

  // Pairs whose manifolds a CloudDispatcher wrote ahead of Bullet's walk.
  std::size_t written() const {
    const auto* own = dynamic_cast<const CloudDispatcher*>(dispatcher.get());
    return own ? own->statistics().written : 0;
  }

  CloudContact clouds;
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  std::unique_ptr<btCollisionDispatcher> dispatcher;
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world{dispatcher.get(), &broadphase, &solver, &configuration};
  std::vector<std::unique_ptr<btRigidBody>> bodies;

 private:
  std::unique_ptr<btCollisionDispatcher> make() {
    return std::make_unique<btCollisionDispatcher>(&configuration);
  }
  std::unique_ptr<btCollisionDispatcher> make(const CloudDispatcherSettings& dispatch) {
    return std::make_unique<CloudDispatcher>(&configuration, dispatch);
  }
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btSoftBody>> softs_;
};

}  // namespace cloudcontact::testing
