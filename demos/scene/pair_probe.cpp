// Does for one pair what btCollisionDispatcher does for each pair of the broad phase.
#include "scene/pair_probe.h"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

#include <chrono>
#include <cstdint>
#include <new>
#include <stdexcept>

#include "scene/bullet_methods.h"
#include "scene/bullet_vectors.h"

namespace cloudcontact::program {

namespace {

// Planes are static, all else moves: Bullet skips pairs of two static bodies. Posed bodies never
// turn, so no one minds their inertia.
std::unique_ptr<btRigidBody> makeBody(btCollisionShape& shape) {
  const bool fixed = shape.getShapeType() == STATIC_PLANE_PROXYTYPE;
  const btRigidBody::btRigidBodyConstructionInfo info(fixed ? 0 : 1, nullptr, &shape,
                                                      btVector3(1, 1, 1));
  auto body = std::make_unique<btRigidBody>(info);
  body->setAngularFactor(0);
  return body;
}

// The same directions in every run, from the high bits of a linear congruential generator.
class Directions {
 public:
  Vec3 next() {
    const double x = draw(), y = draw(), z = draw();
    const Vec3 v(x, y, z);
    return v.norm() > 1e-3 ? Vec3(v.normalized()) : Vec3(Vec3::UnitX());
  }

 private:
  double draw() {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state_ >> 33) / 1073741824.0 - 1;
  }
  std::uint64_t state_ = 1;
};

}  // namespace

// A collision algorithm from the dispatcher's pool, returned by the destructor.
class PairProbe::Algorithm {
 public:
  explicit Algorithm(PairProbe& probe)
      : dispatcher_(probe.dispatcher_),
        a_(nullptr, probe.a_->getCollisionShape(), probe.a_.get(), probe.a_->getWorldTransform(),
           -1, -1),
        b_(nullptr, probe.b_->getCollisionShape(), probe.b_.get(), probe.b_->getWorldTransform(),
           -1, -1),
        algorithm_(dispatcher_.findAlgorithm(&a_, &b_, nullptr, BT_CONTACT_POINT_ALGORITHMS)) {
    if (algorithm_ == nullptr) throw std::runtime_error("Bullet has no algorithm for this pair");
  }
  ~Algorithm() {
    algorithm_->~btCollisionAlgorithm();
    dispatcher_.freeCollisionAlgorithm(algorithm_);
  }
  Algorithm(const Algorithm&) = delete;
  Algorithm& operator=(const Algorithm&) = delete;

  void process() {
    btManifoldResult result(&a_, &b_);
    algorithm_->processCollision(&a_, &b_, info_, &result);
  }

  btManifoldArray manifolds() {
    btManifoldArray all;
    algorithm_->getAllContactManifolds(all);
    return all;
  }

 private:
  btCollisionDispatcher& dispatcher_;
  btCollisionObjectWrapper a_, b_;  // hold the bodies' transforms by reference
  btDispatcherInfo info_;
  btCollisionAlgorithm* algorithm_;
};

PairProbe::PairProbe(btCollisionShape& a, btCollisionShape& b, const Pose& pose,
                     const Motion& motion, Method method, const CloudContactSettings& settings)
    : pose_(pose), seam_(settings), dispatcher_(&configuration_) {
  if (usesClouds(method))
    seam_.attach(dispatcher_);
  else
    registerMethod(dispatcher_, method);
  a_ = makeBody(a);
  b_ = makeBody(b);
  b_->setWorldTransform(toBullet(pose));
  b_->setLinearVelocity(toBullet(motion.linear));
  b_->setAngularVelocity(toBullet(motion.angular));
}

PairProbe::~PairProbe() = default;

std::vector<ProbedPoint> PairProbe::points() {
  b_->setWorldTransform(toBullet(pose_));
  Algorithm algorithm(*this);
  algorithm.process();
  std::vector<ProbedPoint> found;
  btManifoldArray manifolds = algorithm.manifolds();
  for (int m = 0; m < manifolds.size(); ++m) {
    const btPersistentManifold& manifold = *manifolds[m];
    // The manifold's normal points from its body 1 to its body 0, which may be A or B.
    const double sign = manifold.getBody0() == a_.get() ? -1 : 1;
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& p = manifold.getContactPoint(k);
      ProbedPoint point;
      point.position =
          (fromBullet(p.getPositionWorldOnA()) + fromBullet(p.getPositionWorldOnB())) / 2;
      point.normal = sign * fromBullet(p.m_normalWorldOnB);
      point.depth = -double(p.getDistance());
      if (p.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING) {
        point.stiffness = p.m_combinedContactStiffness1;
        point.damping = p.m_combinedContactDamping1;
      }
      point.manifold = m;
      found.push_back(point);
    }
  }
  return found;
}

std::vector<double> PairProbe::microseconds(int repeat, double jitter) {
  using Clock = std::chrono::steady_clock;
  Algorithm algorithm(*this);
  Directions directions;
  std::vector<double> times;
  times.reserve(static_cast<std::size_t>(repeat));
  for (int k = -1; k < repeat; ++k) {
    Pose moved = pose_;
    moved.position += jitter * directions.next();
    b_->setWorldTransform(toBullet(moved));
    const auto start = Clock::now();
    algorithm.process();
    const std::chrono::duration<double, std::micro> time = Clock::now() - start;
    if (k >= 0) times.push_back(time.count());
  }
  return times;
}

}  // namespace cloudcontact::program
