// Springs that pull bodies of a running world (World::setPulls).
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "scene/bullet_vectors.h"
#include "scene/running_world.h"

namespace cloudcontact::program {
namespace {

constexpr double kWeight = 9.81;  // of a kilogram, for the size of a spring, in any gravity [N]
constexpr double kSag = 0.1;      // under the body's weight, in its radii
// Explicit springs are stable up to 2; damping takes its share of that. [rad a step]
constexpr double kMostAngle = 0.25;

// At the start of the step, as gravity is, so that contacts and joints feel it as it is. The force
// of an implicit step of the body alone would be wrong where something else holds the body.
Vec3 forceOf(const BodyPull& pull, const btRigidBody& body, const Vec3& grip) {
  const Vec3 arm = grip - fromBullet(body.getCenterOfMassPosition());
  const Vec3 velocity =
      fromBullet(body.getLinearVelocity()) + fromBullet(body.getAngularVelocity()).cross(arm);
  const Vec3 stretch = pull.to - grip;
  const double length = stretch.norm();
  const double share = length > pull.reach ? pull.reach / length : 1;
  return pull.stiffness * share * stretch - pull.damping * velocity;
}

// The greatest velocity that an impulse of 1 N s gives a point this far from the center of mass.
double mobility(const btRigidBody& body, double arm) {
  const btVector3& spin = body.getInvInertiaDiagLocal();
  return double(body.getInvMass()) + arm * arm * double(std::max({spin.x(), spin.y(), spin.z()}));
}

bool isUsable(double value) {
  return value >= 0 && std::isfinite(value);
}

}  // namespace

void World::State::pull() {
  pullForces.clear();
  for (const BodyPull& pull : pulls) {
    const Body& body = bodies[pull.body];
    pullForces.push_back(Vec3::Zero());
    if (body.cut.gone) continue;
    const Pose now = fromBullet(body.rigid->getWorldTransform()) * body.fromFrame;
    const Vec3 grip = now.toWorld(pull.grip);
    pullForces.back() = forceOf(pull, *body.rigid, grip);
    body.rigid->activate(true);
    body.rigid->applyForce(
        toBullet(pullForces.back()),
        toBullet(Vec3(grip - fromBullet(body.rigid->getCenterOfMassPosition()))));
  }
}

bool World::isPullable(std::size_t body) const {
  const State::Body& b = state_->bodies[body];
  return b.scene.isFree() && !b.soft && !b.cut.gone;
}

BodyPull World::pullOf(std::size_t body, const Vec3& grip, const Vec3& to, double step) const {
  const State::Body& b = state_->bodies[body];
  btVector3 center;
  btScalar radius;
  b.rigid->getCollisionShape()->getBoundingSphere(center, radius);
  BodyPull pull{body, grip, to};
  pull.reach = std::max(double(radius), 1e-9);
  const double moves = mobility(*b.rigid, b.fromFrame.toWorld(grip).norm());
  const double most = kMostAngle / step;  // [rad/s]
  pull.stiffness = std::min(b.parts.mass * kWeight / (kSag * pull.reach), most * most / moves);
  pull.damping = std::min(2 * std::sqrt(pull.stiffness * b.parts.mass), 2 * most / moves);
  return pull;
}

void World::setPulls(std::vector<BodyPull> pulls) {
  for (const BodyPull& pull : pulls) {
    if (pull.body >= bodyCount() || !isPullable(pull.body))
      throw std::invalid_argument("World::setPulls: only bodies that forces move can be pulled");
    if (!pull.grip.allFinite() || !pull.to.allFinite() || !isUsable(pull.stiffness) ||
        !isUsable(pull.damping) || !isUsable(pull.reach))
      throw std::invalid_argument(
          "World::setPulls: places must be finite, stiffness, damping and reach 0 or more");
  }
  state_->pulls = std::move(pulls);
}

const std::vector<BodyPull>& World::pulls() const {
  return state_->pulls;
}
const std::vector<Vec3>& World::pullForces() const {
  return state_->pullForces;
}

}  // namespace cloudcontact::program
