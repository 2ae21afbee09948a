// Tissues in a running world: bodies of several tissues sag as (1) says, by the paper's method and
// where nothing else is stated, and a pair's law has its order of precedence.
#include <gtest/gtest.h>

#include "bullet/bullet_world.h"
#include "bullet/convert.h"

namespace cloudcontact::testing::tissue_world_test {
namespace {

constexpr double kVoxel = 0.005, kEdge = 0.16, kMass = 2, kGravity = 9.81;
constexpr double kSteel = 8e4, kRubber = 1e4;

TissueTable steelAndRubber() {
  const double ratio = 2;  // of the damping to c = sqrt(k m)
  return {{"steel", kSteel, ratio * std::sqrt(kSteel * kMass), 8e9, 1000},
          {"rubber", kRubber, ratio * std::sqrt(kRubber * kMass), 1e8, 1000}};
}

// A cube about its center: steel above, rubber below.
std::shared_ptr<const SurfaceField> twoCube() {
  const auto half = [](double z) {
    return transformed(boxMesh({kEdge, kEdge, kEdge / 2}),
                       {Eigen::Quaterniond::Identity(), {0, 0, z}});
  };
  DigitizeSettings settings;
  settings.voxelSize = kVoxel;
  settings.threads = 1;
  FieldSettings field;
  field.threads = 1;
  return SurfaceField::build(
      digitize({{"steel", half(kEdge / 4)}, {"rubber", half(-kEdge / 4)}}, settings), field);
}

std::unique_ptr<CloudShape> twoShape(bool paper) {
  static const std::shared_ptr<const SurfaceField> kField = twoCube();
  auto shape = std::make_unique<CloudShape>(kField);
  shape->setTissues(tissuesOf(steelAndRubber(), kField->cloud().materials()));
  if (paper) shape->usePaper();
  return shape;
}

struct Side {
  const char* name;
  btQuaternion turn;
  double stiffness;  // by (1)
};

class TwoTissueCube : public ::testing::TestWithParam<bool> {};

// Dropped on each side, the cube comes to rest where the ground's reaction k d is its weight.
TEST_P(TwoTissueCube, SagsAsItsTissuesSay) {
  const btScalar quarter = SIMD_HALF_PI;
  const Side sides[] = {{"rubber", btQuaternion::getIdentity(), kRubber},
                        {"steel", btQuaternion({1, 0, 0}, 2 * quarter), kSteel},
                        {"both", btQuaternion({1, 0, 0}, quarter), (kSteel + kRubber) / 2},
                        {"both", btQuaternion({0, 1, 0}, quarter), (kSteel + kRubber) / 2}};
  for (const Side& side : sides) {
    BulletWorld world;
    world.addGround();
    btRigidBody& cube =
        world.add(twoShape(GetParam()), kMass, at({0, 0, btScalar(kEdge / 2 + 1e-3)}, side.turn));
    for (int i = 0; i < 2000; ++i) world.step(1e-3);
    const double sag = kEdge / 2 - double(cube.getWorldTransform().getOrigin().z());
    const double expected = kMass * kGravity / side.stiffness;
    EXPECT_NEAR(sag, expected, 0.01 * expected) << side.name;
    EXPECT_LT(double(cube.getLinearVelocity().length()), 1e-3) << side.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Normals, TwoTissueCube, ::testing::Bool());

// On a slab of the same tissues the springs act in series, (1) for each body.
TEST(TwoTissueBodies, ActInSeries) {
  for (const bool paper : {false, true}) {
    BulletWorld world;
    world.add(twoShape(paper), 0, at({0, 0, 0}));  // steel on top
    btRigidBody& cube = world.add(twoShape(paper), kMass, at({0, 0, btScalar(kEdge + 1e-3)}));
    for (int i = 0; i < 2000; ++i) world.step(1e-3);
    const double sag = kEdge - double(cube.getWorldTransform().getOrigin().z());
    const double series = kSteel * kRubber / (kSteel + kRubber);
    EXPECT_NEAR(sag, kMass * kGravity / series, 0.01 * kMass * kGravity / series) << paper;
  }
}

TEST(TissueLaw, ALawOfTheWorldComesFirst) {
  CloudContactSettings settings;
  settings.law = KelvinVoigt{4e4, 800};
  BulletWorld world(settings);
  world.addGround();
  btRigidBody& cube = world.add(twoShape(false), kMass, at({0, 0, btScalar(kEdge / 2)}));
  for (int i = 0; i < 2000; ++i) world.step(1e-3);
  const double sag = kEdge / 2 - double(cube.getWorldTransform().getOrigin().z());
  EXPECT_NEAR(sag, kMass * kGravity / 4e4, 0.01 * kMass * kGravity / 4e4);
}

TEST(TissueLaw, RefusesWhatDoesNotFit) {
  auto shape = twoShape(false);
  EXPECT_THROW(shape->setTissues({{"a", 1, 0, 1, 1}, {"b", 1, 0, 1, 1}, {"c", 1, 0, 1, 1}}),
               std::invalid_argument);
  EXPECT_THROW(shape->setTissues({{"a", 0, 0, 1, 1}}), std::invalid_argument);
  // Two laws that do not act in series: counted, and without contacts.
  BulletWorld world;
  auto maxwell = twoShape(false);
  maxwell->setTissues({});
  maxwell->law = Maxwell{1e4, 10};
  world.add(std::move(maxwell), 0, at({0, 0, 0}));
  world.add(twoShape(false), kMass, at({0, 0, btScalar(kEdge - 1e-3)}));
  world.step(1e-3);
  EXPECT_EQ(world.clouds.statistics().failures, 1u);
  EXPECT_EQ(world.points().size(), 0u);
}

// Whoever states nothing has the usual contacts, to the bit; tissues of different hardness state h.
TEST(PaperWorld, IsWhatItsUserStates) {
  const auto restOf = [](bool paper, bool hardness, bool window) {
    BulletWorld world;
    PaperSettings settings;
    settings.hardness = hardness;
    if (window) settings.window = sphereWindow(kVoxel);
    const auto shape = [&] {
      auto made = twoShape(false);
      if (paper) made->usePaper(settings);
      EXPECT_EQ(made->usesPaper(), hardness || window);
      return made;
    };
    world.add(shape(), 0, at({0, 0, 0}));
    btRigidBody& cube = world.add(shape(), kMass,
                                  at({btScalar(0.03), btScalar(0.01), btScalar(kEdge)},
                                     btQuaternion({0, 0, 1}, btScalar(0.4))));
    for (int i = 0; i < 100; ++i) world.step(1e-3);
    return toPose(cube.getWorldTransform()).position;
  };
  const Vec3 usual = restOf(false, false, false);
  EXPECT_EQ(restOf(true, false, false), usual);
  EXPECT_NE(restOf(true, true, false), usual);
  EXPECT_NE(restOf(true, false, true), usual);
}

}  // namespace
}  // namespace cloudcontact::testing::tissue_world_test
