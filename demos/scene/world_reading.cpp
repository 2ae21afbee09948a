// What a World shows of itself: contacts, energy, poses, its state in a number (world.h).
#include <cloudcontact/bullet/shape_report.h>

#include <algorithm>
#include <cstring>
#include <set>

#include "scene/bullet_energy.h"
#include "scene/bullet_vectors.h"
#include "scene/running_world.h"

namespace cloudcontact::program {

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
      moment.energy.spring += springEnergy(p, depth);
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
    const Vec3 center = fromBullet(body.rigid->getWorldTransform().getOrigin());
    moment.energy.kinetic += kineticEnergy(*body.rigid, body.parts.mass, body.parts.inertia);
    moment.energy.potential -= body.parts.mass * gravity.dot(center);
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
bool World::isMeasured(std::size_t body) const {
  return state_->bodies[body].parts.isMeasured;
}
btDiscreteDynamicsWorld& World::bullet() {
  return state_->world;
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
double World::narrowPhaseThreadSeconds() const {
  return state_->dispatcher.threadSeconds();
}
std::vector<std::string> World::advice() const {
  if (!state_->cloudContact) return {};
  return diagnose(state_->world);
}

double World::solverSeconds() const {
  return state_->solver.seconds();
}

WorkDone World::work() const {
  WorkDone work;
  work.sweeps = state_->solver.sweeps();
  work.newton = state_->solver.steps();
  if (!state_->cloudContact) return work;
  const CloudContactStatistics contacts = state_->cloudContact->statistics();
  work.pairs = contacts.pairs;
  work.contacts = contacts.work;
  work.bytes = contacts.bytes;
  return work;
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

bool World::measuresPenetration() const {
  return !state_->measuredPairs().empty();
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
