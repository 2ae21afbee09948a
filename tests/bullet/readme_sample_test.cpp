// Compiles and runs the samples of the README and of docs/bullet.md, and checks that these show
// exactly these lines.
#include <gtest/gtest.h>

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>
#include <cloudcontact/bullet.h>

#include "base/document_sample.h"

namespace readme_sample_test {
namespace {

cloudcontact::Mesh cube(double edge) {
  cloudcontact::Mesh m;
  for (int k = 0; k < 8; ++k)
    m.vertices.push_back(edge * Eigen::Vector3d((k & 1) - 0.5, (k >> 1 & 1) - 0.5, (k >> 2) - 0.5));
  const int quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& q : quads) {
    m.triangles.push_back({q[0], q[1], q[2]});
    m.triangles.push_back({q[0], q[2], q[3]});
  }
  return m;
}

struct World {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
};

// A second with a floor below; the height of the body then.
class Fall {
 public:
  explicit Fall(btDiscreteDynamicsWorld& world) : world_(world) {
    world.addRigidBody(&floor_);
    world.setGravity(btVector3(0, 0, btScalar(-9.81)));
  }
  ~Fall() { world_.removeRigidBody(&floor_); }
  Fall(const Fall&) = delete;
  Fall& operator=(const Fall&) = delete;

  double height(const btRigidBody& body) {
    for (int i = 0; i < 240; ++i) world_.stepSimulation(btScalar(1) / 240, 0, btScalar(1) / 240);
    return body.getCenterOfMassPosition().z();
  }

 private:
  btDiscreteDynamicsWorld& world_;
  btStaticPlaneShape plane_{btVector3(0, 0, 1), 0};
  btRigidBody floor_{btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &plane_)};
};

const btTransform place(btQuaternion::getIdentity(), btVector3(0, 0, btScalar(0.06)));

double heightAfterASecond(World& w, const cloudcontact::Mesh& mesh) {
  btDiscreteDynamicsWorld& world = w.world;
  btCollisionDispatcher& dispatcher = w.dispatcher;
  Fall fall(world);
  // sample begins
  namespace cc = cloudcontact;
  cc::CloudContact contact;        // outlives the dispatcher
  contact.attach(dispatcher);      // from now on the world knows clouds
  cc::recommendedSettings(world);  // solver settings; cc::diagnose(world) explains them

  cc::CloudBody body(mesh, place, {.mass = 1, .law = cc::KelvinVoigt{1e5, 100}});  // [N/m, N s/m]
  body.addTo(world);
  // sample ends
  EXPECT_TRUE(cc::diagnose(world).empty());
  return fall.height(body.body());
}

double heightOfGImpact(World& w, btTriangleMesh& triangles, btScalar mass) {
  btDiscreteDynamicsWorld& world = w.world;
  btCollisionDispatcher& dispatcher = w.dispatcher;
  Fall fall(world);
  // gimpact begins
  btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);

  btGImpactMeshShape shape(&triangles);
  shape.updateBound();
  btVector3 inertia;
  shape.calculateLocalInertia(mass, inertia);
  btRigidBody body(mass, nullptr, &shape, inertia);
  body.setWorldTransform(place);
  world.addRigidBody(&body);
  // gimpact ends
  const double height = fall.height(body);
  world.removeRigidBody(&body);
  return height;
}

double heightOfCloud(World& w, const btTriangleMesh& triangles, double mass) {
  btDiscreteDynamicsWorld& world = w.world;
  btCollisionDispatcher& dispatcher = w.dispatcher;
  Fall fall(world);
  // cloud begins
  cloudcontact::CloudContact contact;  // outlives the dispatcher
  contact.attach(dispatcher);
  cloudcontact::recommendedSettings(world);

  cloudcontact::CloudBody body(cloudcontact::meshOf(triangles), place, {.mass = mass});
  body.addTo(world);
  // cloud ends
  EXPECT_TRUE(cloudcontact::diagnose(world).empty());
  return fall.height(body.body());
}

// A world whose solver knows clouds: the cube rests all the same.
double heightWithOwnSolver(const cloudcontact::Mesh& mesh) {
  btDefaultCollisionConfiguration configuration;
  cloudcontact::CloudContact contact;
  btCollisionDispatcher dispatcher(&configuration);
  contact.attach(dispatcher);
  btDbvtBroadphase broadphase;
  // spared begins
  cloudcontact::NewtonSolver solver;
  solver.cloudsOnly = true;  // and no recommendedSettings()
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  // spared ends
  Fall fall(world);
  cloudcontact::CloudBody body(mesh, place, {.mass = 1});
  body.addTo(world);
  return fall.height(body.body());
}

TEST(BulletSample, AWorldOfTwoSettingsHoldsTheCube) {
  EXPECT_NEAR(heightWithOwnSolver(cube(0.1)), 0.05, 5e-4);
}

// A 1 kg cube of 0.1 m at k = 1e5 N/m stands m g / k = 0.1 mm in the floor.
TEST(ReadmeSample, RestsWhereTheSpringHoldsIt) {
  World w;
  EXPECT_NEAR(heightAfterASecond(w, cube(0.1)), 0.05 - 9.81 / 1e5, 5e-5);
}

// Both hold the cube at half its edge: within GImpact's margins, and within the sag of the spring.
TEST(BulletSample, CloudsTakeGImpactsPlace) {
  const cloudcontact::Mesh mesh = cube(0.1);
  btTriangleMesh triangles;
  const auto at = [&](int i) {
    const Eigen::Vector3d& v = mesh.vertices[static_cast<std::size_t>(i)];
    return btVector3(btScalar(v.x()), btScalar(v.y()), btScalar(v.z()));
  };
  for (const Eigen::Vector3i& t : mesh.triangles)
    triangles.addTriangle(at(t[0]), at(t[1]), at(t[2]));
  World before, after;
  EXPECT_NEAR(heightOfGImpact(before, triangles, 1), 0.05, 0.02);
  EXPECT_NEAR(heightOfCloud(after, triangles, 1), 0.05, 5e-4);
}

constexpr const char* kThis = "tests/bullet/readme_sample_test.cpp";

TEST(ReadmeSample, EqualsTheReadme) {
  cloudcontact::testing::expectSample("README.md", "sample", kThis);
}

TEST(BulletSample, EqualsTheDocument) {
  for (const char* const name : {"gimpact", "cloud", "spared"})
    cloudcontact::testing::expectSample("docs/bullet.md", name, kThis);
}

}  // namespace

}  // namespace readme_sample_test
