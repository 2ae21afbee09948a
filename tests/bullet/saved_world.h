// A world of clouds and Bullet's shapes with contacts of all kinds, and a hash of what a step
// changes.
#pragma once

// First: Bullet's soft bodies declare a global named seed.
#include "bullet/dispatch_stage.h"

#include <BulletDynamics/ConstraintSolver/btHingeConstraint.h>
#include <BulletDynamics/ConstraintSolver/btPoint2PointConstraint.h>

namespace cloudcontact::testing::saved_world {

inline constexpr double kVoxel = 0.0625;
// Bullet's files hold the sizes of its shapes in float: these are none that it would round.
inline constexpr btScalar kMargin = btScalar(0.0625);

inline const std::shared_ptr<const SurfaceField>& cube() {
  static const auto field = fieldOf(boxMesh({1, 1, 1}), kVoxel);
  return field;
}
inline const std::shared_ptr<const SurfaceField>& ball() {
  static const auto field = fieldOf(sphereMesh(0.5, 1e-3), kVoxel);
  return field;
}

// A world of a CloudContact, which keeps nothing but what is in it.
struct FileWorld {
  FileWorld() {
    clouds.attach(dispatcher);
    recommendedSettings(world);
    world.setGravity({0, 0, btScalar(-9.8125)});
  }
  ~FileWorld() {
    for (int i = world.getNumConstraints(); i-- > 0;)
      world.removeConstraint(world.getConstraint(i));
    for (int i = world.getNumCollisionObjects(); i-- > 0;)
      world.removeCollisionObject(world.getCollisionObjectArray()[i]);
  }
  void step() { world.stepSimulation(btScalar(1.0 / 128), 0); }
  std::uint64_t hash() const {
    Hash sum;
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i) {
      const btRigidBody& body = *btRigidBody::upcast(objects[i]);
      for (int row = 0; row < 3; ++row) sum.add(body.getWorldTransform().getBasis()[row]);
      sum.add(body.getWorldTransform().getOrigin());
      sum.add(body.getLinearVelocity());
      sum.add(body.getAngularVelocity());
    }
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
      const btPersistentManifold& manifold =
          *const_cast<btCollisionDispatcher&>(dispatcher).getManifoldByIndexInternal(i);
      for (int k = 0; k < manifold.getNumContacts(); ++k) addTo(sum, manifold.getContactPoint(k));
    }
    return sum.value();
  }
  btRigidBody& body(int i) { return *btRigidBody::upcast(world.getCollisionObjectArray()[i]); }

  CloudContact clouds;  // first: it must outlive the dispatcher
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
};

// Clouds on a cloud and on Bullet's plane, beside and on Bullet's boxes, in compounds, with joints.
struct SavedWorld : FileWorld {
  SavedWorld() {
    add(own(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), btScalar(0))), 0,
        at({0, 0, 0}));
    table = own(std::make_unique<CloudShape>(cube()));
    add(table, 0, at({0, 0, btScalar(0.5)}));
    first = &add(table, 1, at({btScalar(0.25), 0, btScalar(1.5)}));
    first->setAngularVelocity({0, 0, 2});
    auto* const soft = own(std::make_unique<CloudShape>(cube()));
    soft->law = KelvinVoigt{4000, 30};
    add(soft, 2, at({3, 0, btScalar(0.5)})).setLinearVelocity({1, btScalar(0.5), 0});
    auto* const slow = own(std::make_unique<CloudShape>(ball()));
    slow->law = StandardLinearSolid{2000, 3000, 50};
    add(slow, 1, at({6, 0, btScalar(0.55)})).setFriction(btScalar(0.75));
    auto* const round = own(std::make_unique<CloudShape>(ball()));
    round->setFidelity({0.05});
    EXPECT_NE(round->recognized(), nullptr);
    add(round, 1, at({9, 0, btScalar(0.6)})).setLinearVelocity({btScalar(-1), 0, 0});
    addCompound();
    const btVector3 half(btScalar(0.5), btScalar(0.5), btScalar(0.5));
    auto* const box = own(std::make_unique<btBoxShape>(half));
    box->setMargin(kMargin);
    for (int i = 0; i < 3; ++i) add(box, 1 + i, at({15, btScalar(0.125 * i), btScalar(0.5 + i)}));
    add(table, 1, at({15, 0, btScalar(3.5)}));  // on the boxes
    addJoints(*box);
  }
  ~SavedWorld() {
    for (auto& joint : joints) world.removeConstraint(joint.get());
    for (auto& body : bodies) world.removeRigidBody(body.get());
  }

  template <typename Shape>
  Shape* own(std::unique_ptr<Shape> shape) {
    Shape* const made = shape.get();
    shapes.push_back(std::move(shape));
    return made;
  }
  btRigidBody& add(btCollisionShape* shape, double mass, const btTransform& place) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, shape, inertia);
    info.m_startWorldTransform = place;
    bodies.push_back(std::make_unique<btRigidBody>(info));
    world.addRigidBody(bodies.back().get());
    return *bodies.back();
  }
  void addCompound() {
    auto* const compound = own(std::make_unique<btCompoundShape>());
    auto* const end =
        own(std::make_unique<btBoxShape>(btVector3(btScalar(0.25), btScalar(0.25), btScalar(0.5))));
    end->setMargin(kMargin);
    compound->addChildShape(at({btScalar(-0.75), 0, 0}), table);
    compound->addChildShape(at({btScalar(0.75), 0, 0}), table);
    compound->addChildShape(at({btScalar(1.75), 0, 0}), end);
    add(compound, 3, at({12, 4, btScalar(0.625)})).setAngularVelocity({0, 1, 0});
  }
  void addJoints(btBoxShape& box) {
    btRigidBody& door = add(table, 1, at({20, 0, 3}));
    btRigidBody& arm = add(&box, 1, at({22, 0, 3}));
    joints.push_back(std::make_unique<btHingeConstraint>(door, arm, btVector3(1, 0, 0),
                                                         btVector3(-1, 0, 0), btVector3(0, 1, 0),
                                                         btVector3(0, 1, 0)));
    world.addConstraint(joints.back().get(), true);
    joints.push_back(
        std::make_unique<btPoint2PointConstraint>(door, btVector3(btScalar(-0.5), 0, 1)));
    world.addConstraint(joints.back().get());
  }

  CloudShape* table = nullptr;
  btRigidBody* first = nullptr;
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  std::vector<std::unique_ptr<btTypedConstraint>> joints;
};

}  // namespace cloudcontact::testing::saved_world
