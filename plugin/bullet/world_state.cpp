// Worlds go back to a state that they had.
//
// What a step of Bullet's depends on, beside what users set: the rigid bodies, joints that broke,
// time left over, the solver's random numbers, the broad phase (tree_record.h), and the contacts
// (contact_record.h). All of a state is read and checked before the first of it is put back.
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <cloudcontact/bullet/world_state.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <stdexcept>

#include "bullet/contact_record.h"
#include "bullet/shape_record.h"
#include "bullet/tree_record.h"
#include "bullet/world_bytes.h"

namespace cloudcontact {

namespace {

constexpr const char* kStateKind = "CLDSTATE";

// A rigid body: what a step changes, and what tells whether another is the same.
struct BodyRecord {
  btScalar inverseMass = 0;
  std::int32_t shape = 0;
  btTransform place, between;
  btVector3 linear, angular, linearBetween, angularBetween, force, torque;
  std::int32_t activation = 0;
  btScalar still = 0, hit = 0;
};

struct JointRecord {
  bool enabled = true;
  btScalar impulse = 0;
};

struct StateRecord {
  std::int32_t objects = 0;
  std::vector<BodyRecord> bodies;
  std::vector<JointRecord> joints;
  btScalar left = 0;  // of stepSimulation()'s time [s]
  std::uint64_t seed = 0;
  std::optional<TreeRecord> trees;
  std::string contacts;
};

template <typename Archive>
void vectorsIn(Archive& archive, std::initializer_list<btVector3*> vectors) {
  for (btVector3* v : vectors) {
    archive((*v)[0], (*v)[1], (*v)[2]);
    (*v)[3] = 0;  // unused, but Bullet compares it
  }
}

template <typename Archive>
void bodyIn(Archive& archive, BodyRecord& body) {
  archive(body.inverseMass, body.shape, body.activation, body.still, body.hit);
  for (btTransform* at : {&body.place, &body.between}) {
    btMatrix3x3& turn = at->getBasis();
    vectorsIn(archive, {&turn[0], &turn[1], &turn[2], &at->getOrigin()});
  }
  vectorsIn(archive, {&body.linear, &body.angular, &body.linearBetween, &body.angularBetween,
                      &body.force, &body.torque});
}

template <typename Archive>
void stateIn(Archive& archive, StateRecord& state) {
  archive(state.objects, state.left, state.seed);
  listIn(archive, state.bodies, [](Archive& a, BodyRecord& body) { bodyIn(a, body); });
  listIn(archive, state.joints,
         [](Archive& a, JointRecord& joint) { a(joint.enabled, joint.impulse); });
  optionalIn(archive, state.trees, [](Archive& a, TreeRecord& trees) { treesIn(a, trees); });
  archive(state.contacts);
}

std::vector<btCollisionObject*> objectsOf(btDynamicsWorld& world) {
  btCollisionObjectArray& all = world.getCollisionObjectArray();
  std::vector<btCollisionObject*> objects;
  for (int i = 0; i < all.size(); ++i) objects.push_back(all[i]);
  return objects;
}

std::vector<btRigidBody*> bodiesOf(const std::vector<btCollisionObject*>& objects) {
  std::vector<btRigidBody*> bodies;
  for (btCollisionObject* object : objects)
    if (btRigidBody* const body = btRigidBody::upcast(object)) bodies.push_back(body);
  return bodies;
}

BodyRecord recordOf(const btRigidBody& body) {
  BodyRecord record;
  record.inverseMass = body.getInvMass();
  record.shape = body.getCollisionShape()->getShapeType();
  record.place = body.getWorldTransform();
  record.between = body.getInterpolationWorldTransform();
  record.linear = body.getLinearVelocity(), record.angular = body.getAngularVelocity();
  record.linearBetween = body.getInterpolationLinearVelocity();
  record.angularBetween = body.getInterpolationAngularVelocity();
  const btVector3 zero(0, 0, 0);  // what is added to it is never -0
  record.force = zero + body.getTotalForce(), record.torque = zero + body.getTotalTorque();
  record.activation = body.getActivationState();
  record.still = body.getDeactivationTime(), record.hit = body.getHitFraction();
  return record;
}

void restore(const BodyRecord& record, btRigidBody& body) {
  body.setWorldTransform(record.place);
  body.setInterpolationWorldTransform(record.between);
  body.setLinearVelocity(record.linear), body.setAngularVelocity(record.angular);
  body.setInterpolationLinearVelocity(record.linearBetween);
  body.setInterpolationAngularVelocity(record.angularBetween);
  body.updateInertiaTensor();
  // Bullet multiplies what is applied by the body's factors; its total has them.
  const btVector3 linear = body.getLinearFactor(), angular = body.getAngularFactor();
  body.setLinearFactor({1, 1, 1}), body.setAngularFactor(btVector3(1, 1, 1));
  body.clearForces();
  body.applyCentralForce(record.force), body.applyTorque(record.torque);
  body.setLinearFactor(linear), body.setAngularFactor(angular);
  body.forceActivationState(record.activation);
  body.setDeactivationTime(record.still), body.setHitFraction(record.hit);
}

// Bullet tells nobody what stepSimulation() has left over.
struct TimeLeft : btDiscreteDynamicsWorld {
  static btScalar* of(btDynamicsWorld& world) {
    auto* const discrete = dynamic_cast<btDiscreteDynamicsWorld*>(&world);
    return discrete ? &(discrete->*(&TimeLeft::m_localTime)) : nullptr;
  }
};

btSequentialImpulseConstraintSolver* solverOf(btDynamicsWorld& world) {
  return dynamic_cast<btSequentialImpulseConstraintSolver*>(world.getConstraintSolver());
}
btDbvtBroadphase* treePhaseOf(btDynamicsWorld& world) {
  return dynamic_cast<btDbvtBroadphase*>(world.getBroadphase());
}

void require(bool is, const std::string& why) {
  if (!is) throw std::invalid_argument("restoreState: " + why);
}

// Whether the world is one that the state can be of.
void check(const StateRecord& state, btDynamicsWorld& world,
           const std::vector<btCollisionObject*>& objects,
           const std::vector<btRigidBody*>& bodies) {
  require(std::size_t(state.objects) == objects.size() && state.bodies.size() == bodies.size(),
          "the state is of " + std::to_string(state.bodies.size()) + " bodies and " +
              std::to_string(state.objects) + " objects; the world has " +
              std::to_string(bodies.size()) + " and " + std::to_string(objects.size()));
  require(state.joints.size() == std::size_t(world.getNumConstraints()),
          "the state is of " + std::to_string(state.joints.size()) + " joints; the world has " +
              std::to_string(world.getNumConstraints()));
  for (std::size_t i = 0; i < bodies.size(); ++i)
    require(state.bodies[i].inverseMass == bodies[i]->getInvMass() &&
                state.bodies[i].shape == bodies[i]->getCollisionShape()->getShapeType(),
            "body " + std::to_string(i) + " is not the one of the state; give it its mass and " +
                "shape of then");
  checkContacts(state.contacts, bodies.size());
  if (state.trees) validate(*state.trees, objects.size());
}

}  // namespace

WorldState saveState(btDynamicsWorld& world, const CloudContact& contact) {
  const std::vector<btCollisionObject*> objects = objectsOf(world);
  StateRecord state;
  state.objects = static_cast<std::int32_t>(objects.size());
  for (const btCollisionObject* object : objects) {
    const int type = object->getInternalType();
    if (type == btCollisionObject::CO_SOFT_BODY || type == btCollisionObject::CO_FEATHERSTONE_LINK)
      throw std::invalid_argument("saveState: soft and multi-bodies are not kept");
  }
  for (const btRigidBody* body : bodiesOf(objects)) state.bodies.push_back(recordOf(*body));
  for (int i = 0; i < world.getNumConstraints(); ++i) {
    btTypedConstraint& joint = *world.getConstraint(i);
    state.joints.push_back({joint.isEnabled(), joint.internalGetAppliedImpulse()});
  }
  if (const btScalar* const left = TimeLeft::of(world)) state.left = *left;
  if (const auto* const solver = solverOf(world)) state.seed = solver->getRandSeed();
  if (const auto* const phase = treePhaseOf(world)) state.trees = treesOf(*phase, objects);
  state.contacts = contactsOf(world, ContactRecords::narrowPhaseOf(contact));
  ByteWriter writer;
  stateIn(writer, state);
  return {sealed(kStateKind, writer.bytes())};
}

void restoreState(btDynamicsWorld& world, const CloudContact& contact, const WorldState& from) {
  StateRecord state;
  ByteReader reader(opened(kStateKind, from.bytes.data(), from.bytes.size()));
  stateIn(reader, state);
  const std::vector<btCollisionObject*> objects = objectsOf(world);
  const std::vector<btRigidBody*> bodies = bodiesOf(objects);
  check(state, world, objects, bodies);
  const auto restoreBodies = [&] {
    for (std::size_t i = 0; i < bodies.size(); ++i) restore(state.bodies[i], *bodies[i]);
  };
  restoreBodies();
  for (std::size_t i = 0; i < state.joints.size(); ++i) {
    btTypedConstraint& joint = *world.getConstraint(static_cast<int>(i));
    joint.setEnabled(state.joints[i].enabled);
    joint.internalSetAppliedImpulse(state.joints[i].impulse);
  }
  btDbvtBroadphase* const phase = state.trees ? treePhaseOf(world) : nullptr;
  if (!phase) world.updateAabbs(), world.computeOverlappingPairs();
  std::function<void()> restorePhase;
  if (phase) restorePhase = [&] { restoreTrees(*state.trees, *phase, objects); };
  restoreContacts(world, ContactRecords::narrowPhaseOf(contact), bodies, state.contacts,
                  restorePhase);
  restoreBodies();  // where contacts had to be found, pairs that leave have woken theirs
  if (btScalar* const left = TimeLeft::of(world)) *left = state.left;
  if (auto* const solver = solverOf(world)) solver->setRandSeed(state.seed);
}

}  // namespace cloudcontact
