// Compiles and runs the README's sample, and checks that the README shows exactly these lines.
#include <gtest/gtest.h>

#include <btBulletDynamicsCommon.h>
#include <cloudcontact/bullet.h>
#include <cloudcontact/cloudcontact.h>

#include <fstream>
#include <sstream>

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

double heightAfterASecond(World& w, const cloudcontact::Mesh& mesh) {
  btDiscreteDynamicsWorld& world = w.world;
  btCollisionDispatcher& dispatcher = w.dispatcher;
  btStaticPlaneShape plane(btVector3(0, 0, 1), 0);
  btRigidBody floor(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &plane));
  world.addRigidBody(&floor);
  world.setGravity(btVector3(0, 0, btScalar(-9.81)));
  // sample begins
  using namespace cloudcontact;
  DigitizeSettings settings;
  settings.voxelSize = 0.005;  // meters
  Cloud cloud = digitize(mesh, settings);
  cloud = cloud.translated(-cloud.massProperties().centerOfMass);
  CloudShape shape(SurfaceField::build(cloud));  // a btConcaveShape
  shape.law = KelvinVoigt{1e5, 100};             // k [N/m], c [N s/m]

  CloudContact contact;        // outlives the dispatcher
  contact.attach(dispatcher);  // from now on the world knows clouds
  recommendedSettings(world);  // solver settings; diagnose(world) explains them
  // sample ends
  btVector3 inertia;
  shape.calculateLocalInertia(1, inertia);
  btRigidBody body(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape, inertia));
  body.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 0, btScalar(0.06))));
  world.addRigidBody(&body);
  for (int i = 0; i < 240; ++i) world.stepSimulation(btScalar(1) / 240, 0, btScalar(1) / 240);
  const double height = body.getWorldTransform().getOrigin().z();
  world.removeRigidBody(&body);
  world.removeRigidBody(&floor);
  return height;
}

std::string between(const std::string& file, const std::string& begin, const std::string& end) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  const std::string all = text.str();
  const std::size_t a = all.find(begin);
  if (a == std::string::npos) return "no '" + begin + "' in " + file;
  const std::size_t from = all.find('\n', a) + 1;
  return all.substr(from, all.find(end, from) - from);
}

// A 1 kg cube of 0.1 m at k = 1e5 N/m stands m g / k = 0.1 mm in the floor.
TEST(ReadmeSample, RestsWhereTheSpringHoldsIt) {
  World w;
  EXPECT_NEAR(heightAfterASecond(w, cube(0.1)), 0.05 - 9.81 / 1e5, 5e-5);
}

TEST(ReadmeSample, EqualsTheReadme) {
  std::string code =
      between(std::string(CLOUDCONTACT_SOURCE_DIR) + "/tests/bullet/readme_sample_test.cpp",
              "// sample "
              "begins",
              "  // sample "
              "ends");
  std::stringstream lines(code);
  code.clear();
  for (std::string line; std::getline(lines, line);)
    code += (line.size() > 2 ? line.substr(2) : line) + "\n";
  EXPECT_EQ(between(std::string(CLOUDCONTACT_SOURCE_DIR) + "/README.md", "```cpp", "```"), code);
}

}  // namespace
