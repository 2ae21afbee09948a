// One pair's step: wrappers to ContactBody, ContactFinder, points to manifolds or to a query.
#include "cloud_algorithm.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <cloudcontact/bullet/cloud_shape.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <typeinfo>

#include "closest_gap.h"
#include "convert.h"
#include "manifold_writer.h"
#include "narrow_phase.h"
#include "pair_law.h"
#include "pair_memory.h"
#include "shape_conversion.h"

namespace cloudcontact {

namespace {

// The collision algorithm pool's element; release builds of Bullet do not check it.
static_assert(sizeof(CloudAlgorithm) <= 192);

// [voxels a step] Sliding slower than this is not told from a standing contact's solver residue.
constexpr double kSlidingVoxelsPerStep = 1e-3;

constexpr const char* kNoShape =
    "a shape beside a CloudShape has no volume or is not convex: give it volume, or make it a "
    "CloudShape too";
constexpr const char* kBadPose = "a body's pose is NaN or infinite: it has no contacts";

Motion motionOf(const btCollisionObject& object) {
  const Vec3 center = toVec3(object.getWorldTransform().getOrigin());
  // Velocities as they are before this step's gravity: Bullet adds that only in its solver.
  if (const auto* rigid = btRigidBody::upcast(&object))
    return {toVec3(rigid->getLinearVelocity()), toVec3(rigid->getAngularVelocity()), center};
  return {Vec3::Zero(), Vec3::Zero(), center};
}

bool isFinite(const Pose& pose) {
  return pose.position.allFinite() && pose.orientation.coeffs().allFinite();
}

double voxelOf(const ContactBody& a, const ContactBody& b) {
  double size = std::numeric_limits<double>::infinity();
  for (const ContactBody* body : {&a, &b})
    if (body->field) size = std::min(size, body->field->cloud().voxelSize());
  return size;
}

// A query wants the points, or, where the bodies are apart, how far: its own addContactPoint also
// wants a manifold, of which it reads the order of the bodies.
void answer(btManifoldResult& result, const PairSides& sides, const ContactBody& a,
            const ContactBody& b, const ContactResult& contact) {
  btPersistentManifold order(sides.wrapA->getCollisionObject(), sides.wrapB->getCollisionObject(),
                             0, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
  btPersistentManifold* const before = result.getPersistentManifold();
  const auto tell = [&result](const ContactPoint& point) {
    const Vec3 onB = point.position - point.depth / 2 * point.normal;
    result.addContactPoint(toBullet(Vec3(-point.normal)), toBullet(onB),
                           static_cast<btScalar>(-point.depth));
  };
  result.setPersistentManifold(&order);
  for (const ContactPoint& point : contact.points) tell(point);
  if (contact.points.empty() && result.m_closestPointDistanceThreshold > 0)
    if (const auto gap = closestGap(a, b, result.m_closestPointDistanceThreshold)) tell(*gap);
  result.setPersistentManifold(before);
}

// The fastest that a body's points go about its centre [m/s].
double spinSpeed(const ContactBody& body) {
  const double rate = body.motion.angular.norm();
  if (!(rate > 0)) return 0;  // a half-space has no end, but does not turn
  const Eigen::AlignedBox3d box = body.field ? body.field->bounds() : shapeBounds(*body.shape);
  const Vec3 center = body.pose.toLocal(body.motion.center);
  return rate * (box.max() - center).cwiseAbs().cwiseMax((box.min() - center).cwiseAbs()).norm();
}

// How near bodies get points before they touch: a voxel, or as far as fast ones come in a step. A
// spike of 3 m that falls off another's flank comes 1.3 voxels a step, and was 0.7 inside before
// anything stopped it. What turns comes fastest far out: see spinSpeed().
double reachOf(const ContactBody& a, const ContactBody& b, double voxel, double step) {
  const double speed = (a.motion.linear - b.motion.linear).norm() + spinSpeed(a) + spinSpeed(b);
  return std::max(voxel, speed * step);
}

}  // namespace

struct CloudAlgorithm::State {
  State(btDispatcher& dispatcher, NarrowPhase& shared) : narrowPhase(shared), writer(dispatcher) {}

  // One side for the finder; nothing where the shape is neither a cloud nor a convex body.
  std::optional<ContactBody> bodyOf(const btCollisionObjectWrapper& wrap, ConversionCache& cache);
  void process(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
               const btDispatcherInfo& info, btManifoldResult& result);

  NarrowPhase& narrowPhase;
  ManifoldWriter writer;
  ContactFinder finder;  // a pair's own: it remembers the last step's patches, to name them again
  ConversionCache shapeA, shapeB;
  PairMemory memory;  // of a viscoelastic law
};

std::optional<ContactBody> CloudAlgorithm::State::bodyOf(const btCollisionObjectWrapper& wrap,
                                                         ConversionCache& cache) {
  ContactBody body;
  body.pose = toPose(wrap.getWorldTransform());
  body.motion = motionOf(*wrap.getCollisionObject());
  const btCollisionShape& shape = *wrap.getCollisionShape();
  if (shape.getShapeType() == HFFLUID_SHAPE_PROXYTYPE) {
    body.field = &static_cast<const CloudShape&>(shape).field();
    return body;
  }
  const PlacedShape* const placed = cache.of(shape);
  if (!placed) return std::nullopt;
  body.shape = &placed->shape;
  body.pose = body.pose * placed->frame;
  return body;
}

void CloudAlgorithm::State::process(const btCollisionObjectWrapper& a,
                                    const btCollisionObjectWrapper& b, const btDispatcherInfo& info,
                                    btManifoldResult& result) {
  const auto start = std::chrono::steady_clock::now();
  const auto bodyA = bodyOf(a, shapeA), bodyB = bodyOf(b, shapeB);
  const char* const wrong = !bodyA || !bodyB                                   ? kNoShape
                            : !isFinite(bodyA->pose) || !isFinite(bodyB->pose) ? kBadPose
                                                                               : nullptr;
  if (wrong) {
    narrowPhase.countFailure(wrong);
    writer.clear();
    return;
  }
  const double inverse =
      inverseMass(*a.getCollisionObject()) + inverseMass(*b.getCollisionObject());
  const PairSides sides{&a, &b, bodyA->motion, bodyB->motion, inverse > 0 ? 1 / inverse : 0};
  const double voxel = voxelOf(*bodyA, *bodyB);
  const PairLaw law = lawOf(narrowPhase.settings(), a, b, voxel, info.m_timeStep);
  ContactSettings settings{law.form, law.pair};
  settings.samples = narrowPhase.settings().samples;
  // Bullet's queries subclass the result to override addContactPoint; its solver never does. In a
  // step, bodies about to touch get points too: without them a body that has lifted off by a
  // micrometre falls freely for a step, 0.04 mm at 480 Hz, and rattles for ever.
  const bool steps = typeid(result) == typeid(btManifoldResult);
  if (steps) settings.margin = reachOf(*bodyA, *bodyB, voxel, info.m_timeStep);
  const ContactResult& contact = finder.find(*bodyA, *bodyB, settings);
  if (steps) {
    WriteSettings how{law.form, 0, info.m_timeStep, law.automatic, {}};
    if (info.m_timeStep > 0) how.slidingSpeed = kSlidingVoxelsPerStep * voxel / info.m_timeStep;
    if (law.viscoelastic)
      how.shared = memory.row(*law.viscoelastic, sides, contact, writer.manifolds(),
                              knownStep(info.m_timeStep));
    writer.write(sides, contact, how);
    if (law.viscoelastic) memory.remember(sides, writer.manifolds());
  } else {
    answer(result, sides, *bodyA, *bodyB, contact);
  }
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  narrowPhase.count(elapsed.count(), contact.samples, contact.points.size());
}

CloudAlgorithm::CloudAlgorithm(const btCollisionAlgorithmConstructionInfo& info,
                               NarrowPhase& narrowPhase)
    : btCollisionAlgorithm(info),
      state_(std::make_unique<State>(*info.m_dispatcher1, narrowPhase)) {}

CloudAlgorithm::~CloudAlgorithm() = default;

void CloudAlgorithm::processCollision(const btCollisionObjectWrapper* a,
                                      const btCollisionObjectWrapper* b,
                                      const btDispatcherInfo& info, btManifoldResult* result) {
  // Bullet is not exception-safe: what goes wrong is counted, and the pair has no contacts, for old
  // ones would go on pressing where the bodies no longer are.
  try {
    state_->process(*a, *b, info, *result);
    return;
  } catch (const std::exception& failure) {
    state_->narrowPhase.countFailure(failure.what());
  } catch (...) {
    state_->narrowPhase.countFailure("unknown failure in the narrow phase");
  }
  state_->writer.clear();
}

btScalar CloudAlgorithm::calculateTimeOfImpact(btCollisionObject*, btCollisionObject*,
                                               const btDispatcherInfo&, btManifoldResult*) {
  return 1;
}

void CloudAlgorithm::getAllContactManifolds(btManifoldArray& manifolds) {
  for (btPersistentManifold* manifold : state_->writer.manifolds()) manifolds.push_back(manifold);
}

btCollisionAlgorithm* CloudAlgorithm::Factory::CreateCollisionAlgorithm(
    btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper*,
    const btCollisionObjectWrapper*) {
  void* const memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(CloudAlgorithm));
  return new (memory) CloudAlgorithm(info, narrowPhase_);
}

}  // namespace cloudcontact
