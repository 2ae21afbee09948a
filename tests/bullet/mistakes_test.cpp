// Mistakes made on purpose: each is counted, told once, and named by diagnose(), and no NaN reaches
// the other body.
#include <cloudcontact/bullet/diagnosis.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "bullet/bullet_world.h"
#include "mesh/test_meshes.h"

namespace cloudcontact::testing {
namespace {

constexpr double kVoxel = 0.004;
const btScalar kNaN = std::numeric_limits<btScalar>::quiet_NaN();

const auto& cube() {
  static const auto field = fieldOf(boxMesh({0.06, 0.06, 0.06}), kVoxel);
  return field;
}

struct Scene {
  Scene() : world(settings()) {
    floor = &world.addCloud(cube(), 0, at({0, 0, 0}));
    body = &world.addCloud(cube(), 0.5, at({0, 0, btScalar(0.0599)}));
    shape = const_cast<CloudShape*>(CloudShape::of(*body->getCollisionShape()));
  }
  CloudContactSettings settings() {
    CloudContactSettings made;
    made.onFailure = [this](const std::string& message) { told.push_back(message); };
    return made;
  }
  std::vector<std::string> told;
  BulletWorld world;
  btRigidBody *floor = nullptr, *body = nullptr;
  CloudShape* shape = nullptr;
};

struct Mistake {
  const char* word;  // of the message
  bool diagnosed;
  std::function<void(Scene&)> make;
};

TEST(Mistakes, AreCountedAndToldOnce) {
  const Mistake mistakes[] = {
      {"friction", true, [](Scene& s) { s.body->setFriction(kNaN); }},
      {"friction", true, [](Scene& s) { s.floor->setFriction(-1); }},
      {"restitution", true, [](Scene& s) { s.floor->setRestitution(kNaN); }},
      {"stiffness", true, [](Scene& s) { s.body->setContactStiffnessAndDamping(kNaN, 1); }},
      {"damping", true, [](Scene& s) { s.body->setContactStiffnessAndDamping(1e4, -1); }},
      {"stiffness", false,
       [](Scene& s) {
         s.shape->law = KelvinVoigt{double(kNaN), 0};
       }},
      {"velocity", false,
       [](Scene& s) {
         s.floor->setLinearVelocity({0, kNaN, 0});
       }},
      {"scaled", true,
       [](Scene& s) {
         s.shape->setLocalScaling({1, 1, 2});
       }},
      {"scaled", true,
       [](Scene& s) {
         s.shape->setLocalScaling({-1, -1, -1});
       }},
      {"scaled", true, [](Scene& s) {
         s.shape->setLocalScaling({kNaN, 1, 1});
       }}};
  for (const Mistake& mistake : mistakes) {
    Scene scene;
    mistake.make(scene);
    for (int i = 0; i < 10; ++i) scene.world.step(1.0 / 240);
    const CloudContactStatistics counted = scene.world.clouds.statistics();
    EXPECT_EQ(counted.failures, 10u) << mistake.word;
    EXPECT_NE(counted.lastFailure.find(mistake.word), std::string::npos) << counted.lastFailure;
    ASSERT_EQ(scene.told.size(), 1u) << mistake.word;
    EXPECT_EQ(scene.told[0], counted.lastFailure);
    const auto advice = diagnose(scene.world.world);
    EXPECT_EQ(advice.size(), mistake.diagnosed ? 1u : 0u) << mistake.word;
    const btVector3 place = scene.body->getWorldTransform().getOrigin();
    EXPECT_TRUE(std::isfinite(place.x()) && std::isfinite(place.y()) && std::isfinite(place.z()))
        << mistake.word;
  }
}

TEST(Mistakes, NoneIsNoFailure) {
  Scene scene;
  for (int i = 0; i < 10; ++i) scene.world.step(1.0 / 240);
  EXPECT_EQ(scene.world.clouds.statistics().failures, 0u);
  EXPECT_TRUE(scene.told.empty());
  EXPECT_TRUE(diagnose(scene.world.world).empty());
}

// A field scaled is the field of the scaled cloud, to the bit.
TEST(Scaling, IsThatOfTheVoxels) {
  for (const double factor : {0.25, 2.0, 1.7, 1e-3}) {
    const auto wanted = SurfaceField::build(cube()->cloud().scaled(factor));
    EXPECT_EQ(scaled(*cube(), factor)->hash(), wanted->hash()) << factor;
  }
  for (const double factor : {0.0, -1.0, double(kNaN)})
    EXPECT_THROW(scaled(*cube(), factor), std::invalid_argument);
}

// A cube of half the size rests with half its height above the floor, whatever came before.
TEST(Scaling, BodiesTouchAsLargeAsTheyAre) {
  CloudShape first(cube());
  const auto before = first.life();
  first.setLocalScaling({2, 2, 2});
  EXPECT_NE(first.life(), before);
  EXPECT_EQ(&CloudShape(cube()).field(), cube().get());
  for (const double factor : {2.0, 0.5, 1.0}) {
    BulletWorld world;
    world.addGround();
    auto shape = std::make_unique<CloudShape>(cube());
    shape->setLocalScaling({3, 3, 3});
    shape->setLocalScaling({btScalar(factor), btScalar(factor), btScalar(factor)});
    EXPECT_EQ(shape->getLocalScaling().x(), btScalar(factor));
    const double half = 0.03 * factor;
    btRigidBody& body = world.add(std::move(shape), 0.5, at({0, 0, btScalar(half + 1e-3)}));
    for (int i = 0; i < 240; ++i) world.step(1.0 / 240);
    EXPECT_NEAR(body.getWorldTransform().getOrigin().z(), half, 0.2 * factor * kVoxel);
    EXPECT_TRUE(diagnose(world.world).empty());
  }
}

}  // namespace
}  // namespace cloudcontact::testing
