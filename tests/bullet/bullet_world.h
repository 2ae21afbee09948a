// BulletWorld: a small world for tests, with bodies made of clouds or Bullet's own shapes. Tests
// are compiled against Bullet in float and in double.
#pragma once

#include <btBulletDynamicsCommon.h>
#include <cloudcontact/bullet/cloud_contact.h>
#include <cloudcontact/bullet/cloud_shape.h>

#include <memory>
#include <utility>
#include <vector>

#include "contact/contact_cases.h"
#include "field/mesh_field.h"

namespace cloudcontact::testing {

// Rounding of float and double worlds.
constexpr double kRounding = sizeof(btScalar) == 4 ? 1e-5 : 1e-10;

inline btTransform at(const btVector3& position,
                      const btQuaternion& rotation = btQuaternion::getIdentity()) {
  return btTransform(rotation, position);
}

inline std::unique_ptr<CloudShape> exactCloud(const std::shared_ptr<const SurfaceField>& field) {
  auto shape = std::make_unique<CloudShape>(field);
  Fidelity fidelity;
  fidelity.exact = true;
  shape->setFidelity(fidelity);
  return shape;
}

class BulletWorld {
 public:
  explicit BulletWorld(const CloudContactSettings& settings = {}) : clouds(settings) {
    clouds.attach(dispatcher);
    recommendedSettings(world);
    world.setGravity({0, 0, btScalar(-9.81)});
  }
  ~BulletWorld() {
    for (auto& body : bodies_) world.removeRigidBody(body.get());
  }
  BulletWorld(const BulletWorld&) = delete;
  BulletWorld& operator=(const BulletWorld&) = delete;

  // The world keeps the shape. Mass 0: static. Sleeping is off unless the test turns it on.
  template <typename Shape>
  btRigidBody& add(std::unique_ptr<Shape> shape, double mass, const btTransform& place) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, shape.get(), inertia);
    info.m_startWorldTransform = place;
    shapes_.push_back(std::move(shape));
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    if (mass > 0) bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(bodies_.back().get());
    return *bodies_.back();
  }
  // Meets all others by its voxels, also where it is a ball or a box.
  btRigidBody& addCloud(const std::shared_ptr<const SurfaceField>& field, double mass,
                        const btTransform& place) {
    return add(exactCloud(field), mass, place);
  }
  btRigidBody& addGround() {
    return add(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0), 0, at({0, 0, 0}));
  }

  void step(double seconds) { world.stepSimulation(btScalar(seconds), 0); }
  void detect() { world.performDiscreteCollisionDetection(); }

  std::vector<btManifoldPoint> points() const {
    std::vector<btManifoldPoint> all;
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
      const btPersistentManifold& manifold =
          *const_cast<btCollisionDispatcher&>(dispatcher).getManifoldByIndexInternal(i);
      for (int j = 0; j < manifold.getNumContacts(); ++j)
        all.push_back(manifold.getContactPoint(j));
    }
    return all;
  }

  CloudContact clouds;  // first: it must outlive the dispatcher
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};

 private:
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

}  // namespace cloudcontact::testing
