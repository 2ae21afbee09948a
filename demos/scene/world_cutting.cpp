// Bodies that are cut in a running world: how they enter it, what a cut does to them, and the
// pieces that fall off.
#include <algorithm>
#include <string>

#include "scene/bullet_vectors.h"
#include "scene/running_world.h"

namespace cloudcontact::program {

namespace {

// A static body that can be cut is a heavy one that is put back after each step, so that the solver
// finds the force between it and a tool that nothing moves either.
constexpr double kHeldMass = 1e6;  // in its own masses

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

}  // namespace

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
  for (const Joint& joint : joints)
    if (&joint.rows->getRigidBodyA() == body.rigid || &joint.rows->getRigidBodyB() == body.rigid) {
      world.removeConstraint(joint.rows.get());
      joint.rows->setLoad({});
    }
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
    else if (body.soft)
      cutter.addTissue(*body.soft);
}

void World::State::cutAfter(double step) {
  if (!hasTools) return;
  const double before = cuttableEnergy(), held = elasticEnergy();
  std::vector<WorldCut> done = cutter.after(step);
  takeSoftCuts();
  if (!cutter.softCuts().empty()) cutEnergy += held - elasticEnergy();
  if (done.empty()) return;
  for (WorldCut& cut : done) {
    const auto found = std::find_if(bodies.begin(), bodies.end(),
                                    [&](const Body& body) { return body.cuts.get() == cut.body; });
    takeOutcome(static_cast<std::size_t>(found - bodies.begin()), std::move(cut.outcome));
  }
  cutEnergy += before - cuttableEnergy();
}

}  // namespace cloudcontact::program
