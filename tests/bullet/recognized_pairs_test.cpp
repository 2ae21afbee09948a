// Clouds that are recognised as shapes, in Bullet: forces, IDs, settings, and scenes beside the
// same scenes of clouds and of Bullet's primitives.
#include <gtest/gtest.h>

#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <cloudcontact/bullet/shape_report.h>

#include <cmath>
#include <numbers>

#include "bullet/bullet_world.h"
#include "contact/press_direction.h"
#include "law/hulls.h"
#include "mesh/turned_mesh.h"

namespace cloudcontact::testing::recognized_pairs_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kVoxel = 1.0 / 24;

struct Fields {
  std::shared_ptr<const SurfaceField> box = fieldOf(boxMesh({1, 0.8, 0.6}), kVoxel);
  std::shared_ptr<const SurfaceField> ball = fieldOf(sphereMesh(0.5, 1e-4), kVoxel);
  std::shared_ptr<const SurfaceField> rod = fieldOf(test::roundMesh(0.4, 1, 256), kVoxel);
  std::shared_ptr<const SurfaceField> prism =
      fieldOf(test::meshOf(test::prismHull(6, 0.4, 0.3)), kVoxel);
  std::shared_ptr<const SurfaceField> table = fieldOf(boxMesh({6, 3, 0.5}), kVoxel);
};
const Fields& fields() {
  static const Fields all;
  return all;
}

std::unique_ptr<CloudShape> shapeOf(const std::shared_ptr<const SurfaceField>& field,
                                    double tolerance = 0.4 * kVoxel) {
  if (tolerance == 0) return exactCloud(field);
  auto shape = std::make_unique<CloudShape>(field);
  shape->setFidelity({tolerance});
  return shape;
}

TEST(RecognizedPairs, ShapesAreKnownUntilTheyAreCut) {
  const auto shape = shapeOf(fields().box);
  ASSERT_TRUE(shape->recognized());
  EXPECT_STREQ(shapeName(shape->recognized()->placed.solid), "box");
  shape->setField(fields().ball);
  EXPECT_FALSE(shape->recognized());
  shape->setFidelity({0.4 * kVoxel});
  ASSERT_TRUE(shape->recognized());
  EXPECT_STREQ(shapeName(shape->recognized()->placed.solid), "ball");
  EXPECT_THROW(shape->setFidelity({-1}), std::invalid_argument);
}

// Without a setting a body is what its voxels tell, and with `exact` always a cloud.
TEST(RecognizedPairs, ShapesAreKnownWithoutASetting) {
  CloudShape box(fields().box);
  ASSERT_TRUE(box.recognized());
  EXPECT_STREQ(shapeName(box.recognized()->placed.solid), "box");
  EXPECT_LT(box.recognized()->error, 0.15 * kVoxel);
  const std::shared_ptr<CloudShape> exact = exactCloud(fields().box);
  EXPECT_FALSE(exact->recognized());
  Fidelity both{0.4 * kVoxel};
  both.exact = true;
  EXPECT_THROW(exact->setFidelity(both), std::invalid_argument);
  CloudContactSettings settings;
  settings.fidelity = both;
  EXPECT_THROW(CloudContact{settings}, std::invalid_argument);
}

// What was made of a solid is that, exactly and whatever its voxels are, until it is cut.
TEST(RecognizedPairs, ASolidIsWhatItWasMadeOf) {
  const Box made{Vec3(0.5, 0.4, 0.3)};
  CloudShape box(fieldOf(boxMesh({1, 0.8, 0.6}), 4 * kVoxel));
  box.setSolid({made}, kVoxel);
  for (const double tolerance : {0.0, 2 * kVoxel}) {
    box.setFidelity({tolerance});
    ASSERT_TRUE(box.recognized());
    EXPECT_EQ(std::get<Box>(box.recognized()->placed.solid).halfExtents, made.halfExtents);
    EXPECT_EQ(box.recognized()->error, 0);
  }
  EXPECT_EQ(box.voxelSize(), kVoxel);
  EXPECT_EQ(box.cloud().voxelSize(), 4 * kVoxel);
  Fidelity exact;
  exact.exact = true;
  box.setFidelity(exact);
  EXPECT_FALSE(box.recognized());
  box.setField(fields().ball);
  box.setFidelity({});
  EXPECT_STREQ(shapeName(box.recognized()->placed.solid), "ball");
  EXPECT_EQ(box.voxelSize(), kVoxel);  // the ball's own
  EXPECT_THROW(box.setSolid({HalfSpace{}}), std::invalid_argument);
  EXPECT_THROW(box.setSolid({Sphere{-1}}), std::invalid_argument);
  EXPECT_THROW(box.setSolid({made}, -1), std::invalid_argument);
}

// Boxes that start where their faces touch a plane: all of a face bears, not the strip that
// rounding makes touch first.
TEST(RecognizedPairs, FacesThatTouchBearAtOnce) {
  for (const double voxel : {0.003, 0.0035, 0.004, 0.005}) {
    BulletWorld world;
    world.addGround();
    auto box = std::make_unique<CloudShape>(fieldOf(boxMesh({0.06, 0.05, 0.04}), voxel));
    btRigidBody& body = world.add(std::move(box), 0.5, at({-1, 0, btScalar(0.02)}));
    for (int i = 0; i < 20; ++i) {
      world.step(1.0 / 60);
      ASSERT_LT(body.getAngularVelocity().length(), 0.02) << voxel << ", step " << i;
    }
    EXPECT_EQ(world.clouds.statistics().shapes, 20u);
  }
}

// What a pair of bodies answers in one step, at a stated stiffness.
struct Pressed {
  std::vector<btManifoldPoint> points;
  std::size_t shapes = 0, pairs = 0, failures = 0;
};
template <typename Add>
Pressed pressed(const CloudContactSettings& settings, const Add& add) {
  BulletWorld world(settings);
  add(world);
  world.detect();
  const CloudContactStatistics s = world.clouds.statistics();
  return {world.points(), s.shapes, s.pairs, s.failures};
}

TEST(RecognizedPairs, PressWithStiffnessTimesDepth) {
  CloudContactSettings settings;
  settings.law = KelvinVoigt{1e4, 0};
  const double d = 0.01;
  const Pressed box = pressed(settings, [&](BulletWorld& world) {
    world.addGround();
    world.add(shapeOf(fields().box), 1, at({0, 0, btScalar(0.3 - d)}));
  });
  EXPECT_EQ(box.shapes, 1u);
  ASSERT_EQ(box.points.size(), 4u);
  double force = 0;
  for (const btManifoldPoint& p : box.points)
    force += p.m_combinedContactStiffness1 * -p.getDistance();
  EXPECT_NEAR(force, 1e4 * d, 1e4 * 1e-3 * kVoxel);
  const Pressed ball = pressed(settings, [&](BulletWorld& world) {
    world.add(shapeOf(fields().ball), 0, at({0, 0, 0}));
    world.add(shapeOf(fields().ball), 1, at({0, btScalar(0.6), btScalar(0.8 - d)}));
  });
  EXPECT_EQ(ball.shapes, 1u);
  ASSERT_EQ(ball.points.size(), 1u);
  const double apart = std::hypot(0.6, 0.8 - d);
  EXPECT_NEAR(-ball.points[0].getDistance(), 1 - apart, 0.04 * kVoxel);
  EXPECT_NEAR(ball.points[0].m_combinedContactStiffness1, 1e4, 1e-2);
  // A hull of Bullet's; one with a margin has round edges, and meets the cloud.
  for (const double margin : {0., 0.04}) {
    const Pressed hull = pressed(settings, [&](BulletWorld& world) {
      auto shape = std::make_unique<btConvexHullShape>();
      for (const Vec3& corner : test::prismHull(6, 0.4, 0.3).corners)
        shape->addPoint({btScalar(corner.x()), btScalar(corner.y()), btScalar(corner.z())});
      shape->setMargin(btScalar(margin));
      world.add(shapeOf(fields().table), 0, at({0, 0, btScalar(-0.25)}));
      world.add(std::move(shape), 1, at({0, 0, btScalar(0.3 + margin - d)}));
    });
    EXPECT_EQ(hull.shapes, margin == 0 ? 1u : 0u);
    ASSERT_EQ(hull.points.size(), 4u);
    double pushes = 0;
    for (const btManifoldPoint& p : hull.points)
      pushes += p.m_combinedContactStiffness1 * -p.getDistance();
    EXPECT_NEAR(pushes, 1e4 * d, 1e4 * (margin == 0 ? 1e-3 : 0.4) * kVoxel);  // the tolerance
  }
}

TEST(RecognizedPairs, OthersMeetAsClouds) {
  const auto pair = [](BulletWorld& world) {
    world.add(shapeOf(fields().table), 0, at({0, 0, btScalar(-0.25)}));
    world.add(shapeOf(fields().ball), 1, at({0, 0, btScalar(0.49)}));
  };
  const auto stated = [](BulletWorld& world) {
    auto ball = shapeOf(fields().ball);
    PaperSettings paper;
    paper.window = sphereWindow(ball->cloud().voxelSize());
    ball->usePaper(paper);
    world.add(shapeOf(fields().table), 0, at({0, 0, btScalar(-0.25)}));
    world.add(std::move(ball), 1, at({0, 0, btScalar(0.49)}));
  };
  CloudContactSettings area;
  area.law = Foundation{1e6, 0};
  EXPECT_EQ(pressed({}, pair).shapes, 1u);
  CloudContactSettings exact;
  exact.fidelity.exact = true;
  for (const Pressed& other : {pressed(area, pair), pressed({}, stated), pressed(exact, pair)}) {
    EXPECT_EQ(other.shapes, 0u);
    EXPECT_EQ(other.pairs, 1u);
    EXPECT_FALSE(other.points.empty());
  }
  const Pressed unknown = pressed({}, [](BulletWorld& world) {
    world.addCloud(fields().table, 0, at({0, 0, btScalar(-0.25)}));
    world.add(shapeOf(fields().ball), 1, at({0, 0, btScalar(0.49)}));
  });
  EXPECT_EQ(unknown.shapes, 0u);
  EXPECT_FALSE(unknown.points.empty());
  // Boxes nearly all of which overlaps: closed forms of boxes still know the way out.
  const Pressed deep = pressed({}, [](BulletWorld& world) {
    world.add(shapeOf(fields().rod), 0, at({0, 0, 0}));
    world.add(shapeOf(fields().rod), 1, at({btScalar(0.02), 0, btScalar(0.1)}));
  });
  EXPECT_EQ(deep.failures, 0u);
}

TEST(RecognizedPairs, ReportTellsWhatMetAsWhat) {
  BulletWorld world;
  world.add(shapeOf(fields().table), 0, at({0, 0, btScalar(-0.25)}));
  btRigidBody& box = world.add(shapeOf(fields().box), 1, at({-1, 0, btScalar(0.29)}));
  btRigidBody& cloud = world.addCloud(fields().rod, 1, at({1, 0, btScalar(0.49)}));
  world.detect();
  const auto shapes = shapeReport(world.world);
  ASSERT_EQ(shapes.size(), 3u);
  EXPECT_EQ(shapes[1].object, &box);
  ASSERT_TRUE(shapes[1].shape->recognized());
  EXPECT_GT(shapes[1].shape->recognized()->error, 0);
  EXPECT_FALSE(shapes[2].shape->recognized());
  const std::vector<PairReport> pairs = world.clouds.pairs();
  ASSERT_EQ(pairs.size(), 2u);
  for (const PairReport& pair : pairs) {
    const bool asClouds = pair.a == &cloud || pair.b == &cloud;
    EXPECT_EQ(pair.last, asClouds ? Answer::Searched : Answer::Shapes);
    EXPECT_EQ(pair.searched == 0, !asClouds);
    EXPECT_EQ(pair.work.samples == 0, !asClouds);
    EXPECT_LE(pair.work.samples, pair.samples);
    EXPECT_GT(pair.expectedError, 0);
  }
}

// A tenth of a millimeter to ten meters: nothing depends on the unit.
TEST(RecognizedPairs, MillimetersAreLikeMeters) {
  for (const double unit : {1e-3, 1.0}) {
    const auto box = fieldOf(boxMesh(unit * Vec3(1, 0.8, 0.6)), unit * kVoxel);
    const auto rod = fieldOf(test::roundMesh(0.4 * unit, unit, 256), unit * kVoxel);
    CloudContactSettings settings;
    settings.law = KelvinVoigt{1e4, 0};
    const Pressed pair = pressed(settings, [&](BulletWorld& world) {
      world.add(shapeOf(box, 0.4 * unit * kVoxel), 0, at({0, 0, btScalar(-0.3 * unit)}));
      world.add(shapeOf(rod, 0.4 * unit * kVoxel), 1, at({0, 0, btScalar(0.49 * unit)}));
    });
    EXPECT_EQ(pair.shapes, 1u);
    ASSERT_EQ(pair.points.size(), 4u);
    for (const btManifoldPoint& p : pair.points) {
      EXPECT_NEAR(p.getDistance(), -0.01 * unit, 0.01 * unit * kVoxel);
      EXPECT_NEAR(std::hypot(p.m_positionWorldOnA.x(), p.m_positionWorldOnA.y()),
                  0.4 / std::sqrt(2.0) * unit, 0.02 * unit);
    }
  }
}

TEST(RecognizedPairs, ContactTestAnswersLikeTheStep) {
  struct Asked : btCollisionWorld::ContactResultCallback {
    std::vector<double> distances;
    btScalar addSingleResult(btManifoldPoint& p, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper*, int, int) override {
      distances.push_back(p.getDistance());
      return 0;
    }
  } asked;
  BulletWorld world;
  btRigidBody& table = world.add(shapeOf(fields().table), 0, at({0, 0, btScalar(-0.25)}));
  btRigidBody& box = world.add(shapeOf(fields().box), 1, at({0, 0, btScalar(0.29)}));
  world.world.contactPairTest(&table, &box, asked);
  ASSERT_EQ(asked.distances.size(), 4u);
  for (const double distance : asked.distances) EXPECT_NEAR(distance, -0.01, 0.01 * kVoxel);
}

// A capsule, cylinder or cone of random size, as a solid and as Bullet's shape.
std::unique_ptr<btConvexShape> roundShape(int kind, Random& random, Solid& solid) {
  const double r = random.uniform(0.3, 0.8), h = random.uniform(0.3, 0.8);
  switch (kind) {
    case 0:
      solid = Capsule{r, h};
      return std::make_unique<btCapsuleShapeZ>(btScalar(r), btScalar(2 * h));
    case 1:
      solid = Cylinder{r, h};
      return std::make_unique<btCylinderShapeZ>(btVector3(btScalar(r), btScalar(r), btScalar(h)));
    default:
      solid = Cone{r, h, 0};
      return std::make_unique<btConeShapeZ>(btScalar(r), btScalar(2 * h));
  }
}

// The distance of bodies that are apart, against Bullet's GJK on shapes without a margin outside.
TEST(RecognizedPairs, DistanceIsThatOfBulletsGjk) {
  Random random(3);
  for (int trial = 0; trial < 200; ++trial) {
    Solid solids[2];
    std::unique_ptr<btConvexShape> shapes[2];
    Pose poses[2];
    for (int side = 0; side < 2; ++side) {
      shapes[side] = roundShape((trial / (side ? 3 : 1)) % 3, random, solids[side]);
      shapes[side]->setMargin(btScalar(1e-6));
      poses[side].orientation = random.rotation();
    }
    poses[1].position = 2.5 * (random.rotation() * Vec3::UnitX());
    btVoronoiSimplexSolver simplex;
    btGjkPairDetector gjk(shapes[0].get(), shapes[1].get(), &simplex, nullptr);
    btDiscreteCollisionDetectorInterface::ClosestPointInput input;
    const auto placed = [](const Pose& pose) {
      const Eigen::Quaterniond& q = pose.orientation;
      return at(
          {btScalar(pose.position.x()), btScalar(pose.position.y()), btScalar(pose.position.z())},
          {btScalar(q.x()), btScalar(q.y()), btScalar(q.z()), btScalar(q.w())});
    };
    input.m_transformA = placed(poses[0]);
    input.m_transformB = placed(poses[1]);
    btPointCollector found;
    gjk.getClosestPoints(input, found, nullptr);
    if (!found.m_hasResult) continue;
    const auto press =
        pressDirection({&solids[0], poses[0].orientation.toRotationMatrix(), poses[0].position},
                       {&solids[1], poses[1].orientation.toRotationMatrix(), poses[1].position});
    ASSERT_TRUE(press) << trial;
    // A face's direction is kept where another is better by 2 % at most.
    EXPECT_LE(-press->depth, found.m_distance + 1e-4) << trial;
    EXPECT_GE(-press->depth, 0.97 * found.m_distance - 1e-4) << trial;
  }
}

// Scenes as clouds, as shapes, and their outcome.
struct Body {
  std::shared_ptr<const SurfaceField> field;
  double mass;
  btTransform place;
  btVector3 velocity{0, 0, 0};
};
std::vector<btTransform> outcome(const std::vector<Body>& bodies, bool shapes, double seconds,
                                 double step, double friction = 0.5) {
  BulletWorld world;
  std::vector<btRigidBody*> moving;
  for (const Body& body : bodies) {
    btRigidBody& rigid =
        world.add(shapeOf(body.field, shapes ? 0.4 * kVoxel : 0), body.mass, body.place);
    rigid.setFriction(btScalar(friction));
    rigid.setLinearVelocity(body.velocity);
    if (body.mass > 0) moving.push_back(&rigid);
  }
  for (double t = 0; t < seconds; t += step) world.step(step);
  const CloudContactStatistics s = world.clouds.statistics();
  EXPECT_EQ(s.failures, 0u) << s.lastFailure;
  if (shapes)
    EXPECT_EQ(s.shapes, s.pairs);
  else
    EXPECT_EQ(s.shapes, 0u);
  std::vector<btTransform> places;
  for (const btRigidBody* body : moving) places.push_back(body->getWorldTransform());
  return places;
}

const btQuaternion kOnSide(btVector3(1, 0, 0), btScalar(kPi / 2));

TEST(RecognizedPairs, StackStandsWhereCloudsStand) {
  std::vector<Body> bodies = {{fields().table, 0, at({0, 0, btScalar(-0.25)})}};
  for (int i = 0; i < 5; ++i)
    bodies.push_back({fields().box, 1, at({btScalar(0.02 * i), 0, btScalar(0.3 + 0.6 * i)})});
  const auto clouds = outcome(bodies, false, 1, 1.0 / 240),
             shapes = outcome(bodies, true, 4, 1.0 / 240);
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    EXPECT_LE((clouds[i].getOrigin() - shapes[i].getOrigin()).length(), 0.2 * kVoxel) << i;
    EXPECT_LE(shapes[i].getRotation().getAngle(), 0.01) << i;
  }
}

// Hexagonal blocks lie, lean over an edge of the table that bears them, and stand on each other,
// where clouds do.
TEST(RecognizedPairs, PrismsLieWhereCloudsLie) {
  ASSERT_STREQ(shapeName(shapeOf(fields().prism)->recognized()->placed.solid), "hull");
  const btQuaternion side(btVector3(0, 1, 0), btScalar(kPi / 2));
  const std::vector<Body> bodies = {
      {fields().table, 0, at({0, 0, btScalar(-0.25)})},
      {fields().prism, 1, at({-2, 0, btScalar(0.3)})},
      {fields().prism, 1, at({btScalar(-1.9), btScalar(0.1), btScalar(0.9)})},
      {fields().prism, 1, at({0, 0, btScalar(0.4 / std::cos(kPi / 6))}, side)},
      {fields().prism, 1, at({2, btScalar(1.35), btScalar(0.3)})}};
  const auto clouds = outcome(bodies, false, 1, 1.0 / 240),
             shapes = outcome(bodies, true, 4, 1.0 / 240);
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    EXPECT_LE((clouds[i].getOrigin() - shapes[i].getOrigin()).length(), 0.2 * kVoxel) << i;
    EXPECT_LE((shapes[i].getRotation() * clouds[i].getRotation().inverse()).getAngle(), 0.01) << i;
  }
}

TEST(RecognizedPairs, BallsAndCylindersRollFreely) {
  for (const auto& [field, turn] :
       {std::pair{fields().ball, btQuaternion::getIdentity()}, std::pair{fields().rod, kOnSide}}) {
    const double radius = field == fields().ball ? 0.5 : 0.4;
    const std::vector<Body> bodies = {
        {fields().table, 0, at({0, 0, btScalar(-0.25)})},
        {field, 1, at({-2, 0, btScalar(radius)}, turn), btVector3(1, 0, 0)}};
    const auto place = outcome(bodies, true, 2, 1.0 / 240).at(0).getOrigin();
    // It slides first, until it rolls: 5/7 or 2/3 of the speed, less what sliding takes.
    const double rolls = field == fields().ball ? 5.0 / 7 : 2.0 / 3;
    const double slides = (1 - rolls) / (0.25 * 9.81);  // [s]; the combined friction is 0.25
    const double way = slides * (1 + rolls) / 2 + (2 - slides) * rolls;
    EXPECT_NEAR(place.x() + 2, way, 0.02 * way);
    EXPECT_NEAR(place.y(), 0, 0.01);
  }
}

// A drop in any pose onto any shape: the energy never grows beyond the start.
TEST(RecognizedPairs, EnergyDoesNotGrow) {
  Random random(5);
  for (int trial = 0; trial < 16; ++trial) {
    BulletWorld world;
    world.add(shapeOf(fields().table), 0, at({0, 0, btScalar(-0.25)})).setFriction(1);
    const auto& field = trial >= 12      ? fields().prism
                        : trial % 3 == 0 ? fields().box
                        : trial % 3 == 1 ? fields().rod
                                         : fields().ball;
    const btQuaternion turn(
        btVector3(btScalar(random.uniform(-1, 1)), btScalar(random.uniform(-1, 1)), 1).normalized(),
        btScalar(random.uniform(0, 3)));
    btRigidBody& body = world.add(shapeOf(field), 1, at({0, 0, btScalar(1.2)}, turn));
    body.setFriction(btScalar(0.5));
    const auto energy = [&] {
      const btVector3 v = body.getLinearVelocity(), w = body.getAngularVelocity();
      const btVector3 spin = body.getInvInertiaTensorWorld().inverse() * w;
      return 0.5 * v.length2() + 0.5 * w.dot(spin) +
             9.81 * body.getWorldTransform().getOrigin().z();
    };
    const double start = energy();
    for (int i = 0; i < 720; ++i) {
      world.step(1.0 / 240);
      ASSERT_LE(energy(), start * 1.001) << trial << " step " << i;
    }
    EXPECT_LE(body.getLinearVelocity().length(), 1.5) << trial;
    if (body.getWorldTransform().getOrigin().z() < 0) continue;  // rolled off
    EXPECT_EQ(world.clouds.statistics().failures, 0u);
  }
}

}  // namespace
}  // namespace cloudcontact::testing::recognized_pairs_test
