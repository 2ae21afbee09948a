// Mistakes made on purpose: each is counted, told once, and named by diagnose(), and no NaN reaches
// the other body.
#include <cloudcontact/bullet/cloud_body.h>
#include <cloudcontact/bullet/cuttable_body.h>
#include <cloudcontact/bullet/diagnosis.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "bullet/bullet_world.h"
#include "mesh/test_meshes.h"

namespace cloudcontact::testing::mistakes_test {
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
      {"stiffness", true,
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

// Two laws that do not go together, before the bodies meet and when they do.
TEST(Mistakes, TwoLawsAreNamedBeforeTheyMeet) {
  Scene scene;
  auto* const floor = const_cast<CloudShape*>(CloudShape::of(*scene.floor->getCollisionShape()));
  floor->law = KelvinVoigt{1e4, 1};
  scene.shape->law = Foundation{1e7, 1};
  const auto advice = diagnose(scene.world.world);
  ASSERT_EQ(advice.size(), 1u);
  EXPECT_NE(advice[0].find("Object 0 of the world has no contacts with object 1"),
            std::string::npos)
      << advice[0];
  EXPECT_NE(advice[0].find("CloudContactSettings::law"), std::string::npos) << advice[0];
  for (int i = 0; i < 3; ++i) scene.world.step(1.0 / 240);
  ASSERT_EQ(scene.told.size(), 1u);
  EXPECT_NE(advice[0].find(scene.told[0]), std::string::npos) << scene.told[0];
  // Bodies that never meet may have any laws.
  scene.body->getBroadphaseHandle()->m_collisionFilterMask = 0;
  EXPECT_TRUE(diagnose(scene.world.world).empty());
  scene.body->getBroadphaseHandle()->m_collisionFilterMask = -1;
  floor->law = Foundation{1e7, 1};
  EXPECT_TRUE(diagnose(scene.world.world).empty());
}

// A body of its own matter or not, on a floor of the cube.
struct Weighed {
  const char* word;  // of the message; empty: none
  std::function<void(BulletWorld&)> add;
};

void addWith(BulletWorld& world, const std::shared_ptr<const SurfaceField>& field,
             const btVector3& inertia) {
  world.addCloud(field, 1, at({0, 0, btScalar(0.0599)})).setMassProps(1, inertia);
}

std::shared_ptr<const SurfaceField> placed(const Mesh& mesh, const Vec3& by, double angle = 0) {
  return fieldOf(
      transformed(mesh, {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3::UnitZ())), by}), kVoxel);
}

btVector3 guess(const SurfaceField& field) {
  btVector3 inertia;
  CloudShape(std::make_shared<SurfaceField>(field)).calculateLocalInertia(1, inertia);
  return inertia;
}

TEST(Mistakes, MatterThatIsNotBulletsIsTold) {
  const Mesh bar = boxMesh({0.12, 0.04, 0.06});
  const btVector3 cubes = guess(*cube()), bars = guess(*placed(bar, Vec3::Zero()));
  const Weighed rows[] = {
      {"", [&](BulletWorld& w) { addWith(w, cube(), cubes); }},
      // Off its center: by its base, which CAD programs put at the origin, or far away.
      {"center of mass",
       [&](BulletWorld& w) {
         addWith(w, placed(boxMesh({0.06, 0.06, 0.06}), {0, 0, 0.03}), cubes);
       }},
      {"center of mass",
       [&](BulletWorld& w) {
         addWith(w, placed(boxMesh({0.06, 0.06, 0.06}), {0.1, 0, 0}),
                 btVector3(btScalar(8e-4), btScalar(9e-3), btScalar(9e-3)));
       }},
      {"",
       [&](BulletWorld& w) {
         addWith(w, placed(boxMesh({0.06, 0.06, 0.06}), {0, 0, 0.002}), cubes);
       }},
      // Turned: the diagonal that calculateLocalInertia() gives, or the bar's own moments.
      {"principal axes",
       [&](BulletWorld& w) {
         const auto turned = placed(bar, Vec3::Zero(), 0.5);
         addWith(w, turned, guess(*turned));
       }},
      {"principal axes", [&](BulletWorld& w) { addWith(w, placed(bar, Vec3::Zero(), 0.5), bars); }},
      {"principal axes",
       [&](BulletWorld& w) {
         addWith(w, placed(bar, Vec3::Zero()), {bars.y(), bars.x(), bars.z()});
       }},
      {"", [&](BulletWorld& w) { addWith(w, placed(bar, Vec3::Zero(), 0.01), bars); }},
      // None, in other units, or of a part of the body.
      {"no inertia",
       [&](BulletWorld& w) {
         addWith(w, cube(), {0, 0, 0});
       }},
      {"none that its mass", [&](BulletWorld& w) { addWith(w, cube(), 1e6 * cubes); }},
      {"none that its mass", [&](BulletWorld& w) { addWith(w, cube(), btScalar(0.05) * cubes); }},
      {"none that its mass",
       [&](BulletWorld& w) {
         addWith(w, cube(), {cubes.x(), cubes.y(), 10 * cubes.z()});
       }},
      // Stated: hollow, or with ballast below. An inertia that no rule gives is one that is known.
      {"", [&](BulletWorld& w) { addWith(w, cube(), btScalar(5.0 / 3) * cubes); }},
      {"", [&](BulletWorld& w) {
         addWith(w, placed(boxMesh({0.06, 0.06, 0.06}), {0, 0, 0.02}),
                 btScalar(0.5) * btVector3(cubes.x(), cubes.y(), btScalar(1.4) * cubes.z()));
       }}};
  int number = 0;
  for (const Weighed& row : rows) {
    SCOPED_TRACE(std::to_string(number++) + " " + row.word);
    std::vector<std::string> told;
    CloudContactSettings settings;
    settings.onFailure = [&](const std::string& message) { told.push_back(message); };
    BulletWorld world(settings);
    world.addCloud(cube(), 0, at({0, 0, 0}));
    row.add(world);
    const auto advice = diagnose(world.world);
    for (int i = 0; i < 3; ++i) world.step(1.0 / 240);
    EXPECT_EQ(world.clouds.statistics().failures, 0u);
    const std::size_t wanted = *row.word ? 1 : 0;
    ASSERT_EQ(advice.size(), wanted) << (advice.empty() ? "" : advice[0]);
    ASSERT_EQ(told.size(), wanted);
    if (wanted == 0) continue;
    EXPECT_NE(told[0].find(row.word), std::string::npos) << told[0];
    EXPECT_EQ(advice[0], "Object 1 of the world: " + told[0] + ".");
    EXPECT_TRUE(advice[0].find(": make it a CloudBody") != std::string::npos ||
                advice[0].find(": give it one") != std::string::npos)
        << "no remedy";
  }
}

// Halves of different densities have their center beside the voxels' own, and a known inertia.
TEST(Mistakes, BodiesOfTwoDensitiesAreNone) {
  for (const double ratio : {1.0, 1.35, 2.0, 13.0})
    for (const Vec3& halves : {Vec3(0.06, 0, 0), Vec3(0, 0.02, 0), Vec3(0, 0, 0.03)}) {
      Vec3 edges(0.12, 0.04, 0.06);
      edges -= halves;
      const std::vector<NamedMesh> parts = {
          {"heavy", transformed(boxMesh(edges), {Eigen::Quaterniond::Identity(), halves / 2})},
          {"light", transformed(boxMesh(edges), {Eigen::Quaterniond::Identity(), -halves / 2})}};
      CloudBodySettings settings;
      settings.voxelSize = 0.002;
      CloudBody uniform(parts, at({0, 0, 1}), settings);
      const bool first = uniform.shape().field().cloud().materials()[0] == "heavy";
      settings.densities = {first ? 1000 * ratio : 1000, first ? 1000 : 1000 * ratio};
      CuttableBodySettings cuttable;
      cuttable.densities = settings.densities;
      BulletWorld world;
      CloudBody body(parts, at({0, 0, 1}), settings);
      CuttableBody cut(uniform.shape().field().cloud(), at({1, 0, 1}), cuttable);
      body.addTo(world.world);
      cut.addTo(world.world);
      EXPECT_TRUE(diagnose(world.world).empty()) << ratio << ' ' << halves.transpose();
    }
}

// What may not turn needs no inertia; what contacts do not move needs no center.
TEST(Mistakes, BodiesThatDoNotTurnAreLeftAlone) {
  BulletWorld world;
  world.addCloud(placed(boxMesh({0.06, 0.06, 0.06}), {1, 2, 3}), 0, at({0, 0, 0}));
  btRigidBody& upright = world.addCloud(cube(), 1, at({0, 0, 1}));
  upright.setMassProps(1, {0, 0, 0});
  EXPECT_EQ(diagnose(world.world).size(), 1u);
  upright.setAngularFactor(btScalar(0));
  EXPECT_TRUE(diagnose(world.world).empty());
  upright.setMassProps(1, {1, 1, 1});
  EXPECT_TRUE(diagnose(world.world).empty());
}

// Clouds of a compound are weighed together; beside other shapes, whose density is not known, not.
TEST(Mistakes, CompoundsAreWeighedAsAWhole) {
  for (const double lift : {0.0, 0.03})
    for (const bool mixed : {false, true}) {
      auto left = std::make_unique<CloudShape>(cube()),
           right = std::make_unique<CloudShape>(cube());
      btSphereShape ball(btScalar(0.01));
      auto both = std::make_unique<btCompoundShape>();
      both->addChildShape(at({btScalar(-0.05), 0, btScalar(lift)}), left.get());
      both->addChildShape(at({btScalar(0.05), 0, btScalar(lift)}), right.get());
      if (mixed) both->addChildShape(at({0, 0, 0}), &ball);
      BulletWorld world;
      world.add(std::move(both), 1, at({0, 0, 0}));
      const auto advice = diagnose(world.world);
      EXPECT_EQ(advice.size(), lift > 0 && !mixed ? 1u : 0u) << lift << mixed;
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
}  // namespace cloudcontact::testing::mistakes_test
