// Boxes, balls, capsules, cylinders, cones and hexagonal blocks as clouds, as shapes that were
// recognised in clouds, and as Bullet's primitives: processor time of one thread a pair and step in
// running scenes, in one run. Each body lies on a box, or on one of its own kind, which is fixed.
// The three take turns in rounds; the medians are printed.
//
// shapes [steps] [voxels across]
#include <btBulletDynamicsCommon.h>
#include <cloudcontact/bullet/cloud_contact.h>
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/voxels/digitize.h>

#include <cstdio>
#include <cstdlib>
#include <memory>

#include "contact/contact_cases.h"
#include "law/hulls.h"
#include "mesh/turned_mesh.h"
#include "timing.h"

namespace {

using namespace cloudcontact;

constexpr double kStep = 1.0 / 240;
constexpr int kPairs = 30, kRounds = 7;

// Times the narrow phase.
class TimedDispatcher : public btCollisionDispatcher {
 public:
  using btCollisionDispatcher::btCollisionDispatcher;
  void dispatchAllCollisionPairs(btOverlappingPairCache* cache, const btDispatcherInfo& info,
                                 btDispatcher* dispatcher) override {
    const double start = threadSeconds();
    btCollisionDispatcher::dispatchAllCollisionPairs(cache, info, dispatcher);
    seconds += threadSeconds() - start;
    pairs += cache->getNumOverlappingPairs();
  }
  double seconds = 0, pairs = 0;
};

struct Kind {
  const char* name;
  Mesh mesh;
  std::shared_ptr<btCollisionShape> primitive;
  double height;      // of its center when it lies
  btQuaternion lies;  // turned so
  std::shared_ptr<const SurfaceField> field;
};

enum class Method { Cloud, Shape, Primitive };

std::shared_ptr<btCollisionShape> shapeOf(const Kind& kind, Method method, double tolerance) {
  if (method == Method::Primitive) return kind.primitive;
  auto shape = std::make_shared<CloudShape>(kind.field);
  Fidelity fidelity;
  fidelity.exact = method == Method::Cloud;
  if (!fidelity.exact) fidelity.tolerance = tolerance;
  shape->setFidelity(fidelity);
  if (method == Method::Shape && !shape->recognized()) std::printf("%s: no shape!\n", kind.name);
  return shape;
}

struct Cost {
  double narrow = 0, step = 0;  // [s] a pair and step
  double low = 0;               // [m] how far the bodies sank, in the mean
};

class Scene {
 public:
  Scene(const Kind& moving, const Kind& fixed, Method method, double tolerance) {
    clouds_.attach(dispatcher_);
    recommendedSettings(world_);
    world_.setGravity({0, 0, btScalar(-9.81)});
    top_ = shapeOf(moving, method, tolerance);
    base_ = shapeOf(fixed, method, tolerance);
    for (int i = 0; i < kPairs; ++i) {
      const btScalar x = btScalar(4 * i);
      add(*base_, 0, btTransform(fixed.lies, btVector3(x, 0, btScalar(-fixed.height))));
      add(*top_, 1, btTransform(moving.lies, btVector3(x, 0, btScalar(moving.height))));
    }
    start_ = moving.height;
  }
  ~Scene() {
    for (auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) world_.stepSimulation(btScalar(kStep), 0);
  }
  Cost measured(int steps) {
    dispatcher_.seconds = dispatcher_.pairs = 0;
    const double start = threadSeconds();
    run(steps);
    Cost cost{dispatcher_.seconds / dispatcher_.pairs,
              (threadSeconds() - start) / dispatcher_.pairs, 0};
    for (std::size_t i = 1; i < bodies_.size(); i += 2)
      cost.low += (start_ - bodies_[i]->getWorldTransform().getOrigin().z()) / kPairs;
    return cost;
  }

 private:
  void add(btCollisionShape& shape, double mass, const btTransform& place) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape.calculateLocalInertia(btScalar(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, &shape, inertia);
    info.m_startWorldTransform = place;
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(bodies_.back().get());
  }

  CloudContact clouds_;
  btDefaultCollisionConfiguration configuration_;
  TimedDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::shared_ptr<btCollisionShape> top_, base_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  double start_ = 0;
};

void compare(const Kind& moving, const Kind& fixed, double tolerance, int steps) {
  Scene scenes[] = {{moving, fixed, Method::Cloud, tolerance},
                    {moving, fixed, Method::Shape, tolerance},
                    {moving, fixed, Method::Primitive, tolerance}};
  std::vector<double> narrow[3], step[3];
  double low[3];
  for (Scene& scene : scenes) scene.run(steps);
  for (int round = 0; round < kRounds; ++round)
    for (int m = 0; m < 3; ++m) {
      const Cost cost = scenes[m].measured(m == 0 ? steps / 10 : steps);
      narrow[m].push_back(cost.narrow);
      step[m].push_back(cost.step);
      low[m] = cost.low;
    }
  double n[3], s[3];
  for (int m = 0; m < 3; ++m) n[m] = 1e9 * median(narrow[m]), s[m] = 1e9 * median(step[m]);
  std::printf("%-9s on %-9s %8.0f %6.0f %6.0f | %6.1f %5.2f | %6.2f %5.2f | %8.5f %8.5f %8.5f\n",
              moving.name, fixed.name, n[0], n[1], n[2], n[0] / n[2], n[1] / n[2], s[0] / s[2],
              s[1] / s[2], low[0], low[1], low[2]);
}

std::shared_ptr<btCollisionShape> hullShape(const Hull& hull) {
  auto shape = std::make_shared<btConvexHullShape>();
  for (const Vec3& c : hull.corners)
    shape->addPoint(btVector3(btScalar(c.x()), btScalar(c.y()), btScalar(c.z())));
  shape->initializePolyhedralFeatures();
  return shape;
}

std::vector<Kind> kindsOf() {
  const Hull block = test::prismHull(6, 0.4, 0.4);
  const btQuaternion upright = btQuaternion::getIdentity();
  const btQuaternion onSide(btVector3(1, 0, 0), SIMD_HALF_PI);
  const auto can = test::roundMesh(0.4, 1.0, 256);
  const auto canShape = std::make_shared<btCylinderShapeZ>(btVector3(0.4, 0.4, 0.5));
  return {{"box",
           testing::boxMesh({1, 1, 1}),
           std::make_shared<btBoxShape>(btVector3(0.5, 0.5, 0.5)),
           0.5,
           upright,
           {}},
          {"ball",
           testing::sphereMesh(0.5, 1e-4),
           std::make_shared<btSphereShape>(0.5),
           0.5,
           upright,
           {}},
          {"capsule",
           test::capsuleMesh(0.3, 0.3, 256),
           std::make_shared<btCapsuleShapeZ>(0.3, 0.6),
           0.3,
           onSide,
           {}},
          {"cylinder", can, canShape, 0.5, upright, {}},
          {"rolling", can, canShape, 0.4, onSide, {}},
          {"cone",
           test::coneMesh(0.5, 0.5, 256),
           std::make_shared<btConeShapeZ>(0.5, 1.0),
           0.5,
           upright,
           {}},
          {"block", test::meshOf(block), hullShape(block), 0.4, upright, {}}};
}

}  // namespace

int main(int argc, char** argv) {
  const int steps = argc > 1 ? std::atoi(argv[1]) : 100;
  const double across = argc > 2 ? std::atof(argv[2]) : 32;
  std::vector<Kind> kinds = kindsOf();
  DigitizeSettings settings;
  settings.voxelSize = 1 / across;
  for (Kind& kind : kinds) kind.field = SurfaceField::build(digitize(kind.mesh, settings));
  std::printf(
      "ns a pair and step: narrow phase           | ratio of it  | of all steps | sunk [m]\n"
      "                       cloud  shape Bullet |  cloud shape |  cloud shape |    cloud    "
      "shape   Bullet\n");
  for (const Kind& kind : kinds) compare(kind, kinds[0], 0.01, steps);
  for (const Kind& kind : kinds)
    if (&kind != &kinds[0] && &kind != &kinds[5]) compare(kind, kind, 0.01, steps);
}
