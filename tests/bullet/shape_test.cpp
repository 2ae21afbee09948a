// CloudShape as a Bullet shape, and the surface, axis and margin of each convex Bullet shape that a
// cloud can touch.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>

#include "bullet/bullet_world.h"

namespace cloudcontact::testing::shape_test {
namespace {

constexpr double kVoxel = 0.005, kRadius = 0.1;

std::shared_ptr<const SurfaceField> ballField() {
  static const auto field = fieldOf(sphereMesh(kRadius, 1e-6), kVoxel);
  return field;
}

std::shared_ptr<const SurfaceField> slabField() {
  static const auto field = fieldOf(boxMesh({0.2, 0.3, 0.1}), kVoxel);
  return field;
}

btVector3 v(double x, double y, double z) {
  return {btScalar(x), btScalar(y), btScalar(z)};
}

using ShapeMaker = std::function<std::unique_ptr<btCollisionShape>()>;

template <typename Shape, typename... Args>
ShapeMaker make(Args... args) {
  return [=] { return std::make_unique<Shape>(args...); };
}

std::unique_ptr<btCollisionShape> octahedron(double margin) {
  auto hull = std::make_unique<btConvexHullShape>();
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-0.3, 0.3}) {
      btVector3 corner(0, 0, 0);
      corner[axis] = btScalar(side);
      hull->addPoint(corner);
    }
  hull->setMargin(btScalar(margin));
  return hull;
}

template <typename Cone>
ShapeMaker cone() {
  return [] {
    auto shape = std::make_unique<Cone>(btScalar(0.3), btScalar(0.8));
    shape->setMargin(0);
    return shape;
  };
}

// A point of a shape's surface and its normal, by formula.
struct Touch {
  const char* name;
  ShapeMaker shape;
  btVector3 surface, normal;
};

std::vector<Touch> touches() {
  const btScalar r = btScalar(0.3), h = btScalar(0.8);
  const btVector3 x = v(1, 0, 0), y = v(0, 1, 0), z = v(0, 0, 1);
  // On a cone's slope, half way up: 0.15 from the axis; its normal leans by radius / height.
  const double slopeOut = 0.8 / std::hypot(0.8, 0.3), slopeUp = 0.3 / std::hypot(0.8, 0.3);
  const double third = 1 / std::sqrt(3.0);
  const btVector3 half = v(0.2, 0.3, 0.4);
  return {
      {"plane", make<btStaticPlaneShape>(v(0, 0.6, 0.8), btScalar(0.3)), v(0, 0.18, 0.24),
       v(0, 0.6, 0.8)},
      {"box, x", make<btBoxShape>(half), v(0.2, 0.1, 0), x},
      {"box, -y", make<btBoxShape>(half), v(0.05, -0.3, 0.1), -y},
      {"sphere", make<btSphereShape>(r), v(0.18, 0, 0.24), v(0.6, 0, 0.8)},
      {"capsule Y, side", make<btCapsuleShape>(r, h), v(0.3, 0.2, 0), x},
      {"capsule Y, cap", make<btCapsuleShape>(r, h), v(0, 0.7, 0), y},
      {"capsule X, cap", make<btCapsuleShapeX>(r, h), v(-0.7, 0, 0), -x},
      {"capsule Z, cap", make<btCapsuleShapeZ>(r, h), v(0, 0, 0.7), z},
      {"capsule Z, side", make<btCapsuleShapeZ>(r, h), v(0, 0.3, -0.2), y},
      {"cylinder Y, side", make<btCylinderShape>(v(0.3, 0.4, 0.3)), v(0, 0.1, 0.3), z},
      {"cylinder Y, end", make<btCylinderShape>(v(0.3, 0.4, 0.3)), v(0.1, 0.4, 0), y},
      {"cylinder X, end", make<btCylinderShapeX>(v(0.4, 0.3, 0.3)), v(0.4, 0.1, 0), x},
      {"cylinder X, side", make<btCylinderShapeX>(v(0.4, 0.3, 0.3)), v(0.1, 0, 0.3), z},
      {"cylinder Z, end", make<btCylinderShapeZ>(v(0.3, 0.3, 0.4)), v(0, 0.1, -0.4), -z},
      {"cone Y, base", cone<btConeShape>(), v(0.05, -0.4, 0), -y},
      {"cone Y, slope", cone<btConeShape>(), v(0.15, 0, 0), v(slopeOut, slopeUp, 0)},
      {"cone X, slope", cone<btConeShapeX>(), v(0, 0.15, 0), v(slopeUp, slopeOut, 0)},
      {"cone Z, slope", cone<btConeShapeZ>(), v(0.15, 0, 0), v(slopeOut, 0, slopeUp)},
      {"hull", [] { return octahedron(0); }, v(0.1, 0.1, 0.1), v(third, third, third)},
      {"hull with a margin", [] { return octahedron(0.05); },
       v(0.1 + 0.05 * third, 0.1 + 0.05 * third, 0.1 + 0.05 * third), v(third, third, third)},
      {"scaled box",
       [=] {
         auto box = std::make_unique<btBoxShape>(half);
         box->setLocalScaling(v(2, 1, 1));
         return box;
       },
       v(0.4, 0, 0), x},
      {"multi-sphere",
       [=] {
         const btVector3 centers[] = {v(-0.4, 0, 0), v(0.4, 0, 0)};
         const btScalar radii[] = {r, r};
         return std::make_unique<btMultiSphereShape>(centers, radii, 2);
       },
       v(0.1, 0.3, 0), y},
  };
}

struct Deepest : btCollisionWorld::ContactResultCallback {
  double depth = -1;
  btVector3 normal{0, 0, 0};
  btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                           const btCollisionObjectWrapper*, int, int) override {
    normal += point.m_normalWorldOnB;
    depth = std::max<double>(depth, -point.m_distance1);
    return 0;
  }
};

TEST(PlainShapes, ACloudBallMeetsEachAtItsFormulasSurface) {
  const double depth = 0.6 * kVoxel;
  const btTransform place =
      at(v(1, -2, 0.5), btQuaternion(v(1, 2, -1).normalized(), btScalar(1.1)));
  for (const Touch& touch : touches()) {
    BulletWorld scene;
    btRigidBody& plain = scene.add(touch.shape(), 0, place);
    const btVector3 center = touch.surface + touch.normal * btScalar(kRadius - depth);
    btRigidBody& ball = scene.addCloud(ballField(), 1, place * at(center));
    Deepest found;
    scene.world.contactPairTest(&ball, &plain, found);
    // The multi-sphere is a hull of 1,000 support points: within 0.5 % of its radius, 0.3 voxel.
    const double error = std::string(touch.name) == "multi-sphere" ? 0.4 : 0.1;
    EXPECT_NEAR(found.depth / kVoxel, depth / kVoxel, error) << touch.name;
    const btVector3 wanted = place.getBasis() * touch.normal;
    ASSERT_GT(found.normal.length(), 0) << touch.name;
    const double cosine = std::min<double>(1, found.normal.normalized().dot(wanted));
    EXPECT_LT(std::acos(cosine) * 57.3, error == 0.4 ? 5 : 1) << touch.name;
  }
}

TEST(PlainShapes, AConversionFollowsTheShapeWhenItChanges) {
  BulletWorld scene;
  auto box = std::make_unique<btBoxShape>(v(0.2, 0.2, 0.2));
  btBoxShape& shape = *box;
  scene.add(std::move(box), 0, at({0, 0, 0}));
  scene.addCloud(ballField(), 1, at(v(0, 0, 0.298)));
  scene.detect();
  EXPECT_FALSE(scene.points().empty());
  shape.setLocalScaling(v(1, 1, 0.5));
  scene.detect();
  EXPECT_TRUE(scene.points().empty()) << "the old box is still felt";
}

TEST(CloudShape, ItsBoundsHoldItAndFit) {
  CloudShape shape(slabField());
  btVector3 low, high;
  shape.getAabb(at(v(1, 2, 3), btQuaternion(v(0, 0, 1), btScalar(SIMD_HALF_PI))), low, high);
  // Turned by 90 degrees about z: 0.3 along x, 0.2 along y.
  const btVector3 wantedLow = v(0.85, 1.9, 2.95), wantedHigh = v(1.15, 2.1, 3.05);
  EXPECT_NEAR((low - wantedLow).length(), 0, 2 * kVoxel);
  EXPECT_NEAR((high - wantedHigh).length(), 0, 2 * kVoxel);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LE(low[axis], wantedLow[axis] + 0.01 * kVoxel);
    EXPECT_GE(high[axis], wantedHigh[axis] - 0.01 * kVoxel);
  }
}

TEST(CloudShape, ItsInertiaIsTheSolids) {
  btVector3 slab, ball;
  CloudShape(slabField()).calculateLocalInertia(12, slab);
  EXPECT_NEAR(slab.x(), 0.09 + 0.01, 0.001 * 0.1);  // m / 12 (y^2 + z^2)
  EXPECT_NEAR(slab.y(), 0.04 + 0.01, 0.001 * 0.05);
  EXPECT_NEAR(slab.z(), 0.04 + 0.09, 0.001 * 0.13);
  CloudShape(ballField()).calculateLocalInertia(5, ball);
  EXPECT_NEAR(ball.x(), 0.4 * 5 * kRadius * kRadius, 0.005 * 0.02);
}

TEST(CloudShape, PrincipalFrameTurnsASkewBodyStraight) {
  const Pose turned{Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Vec3(1, 2, 2).normalized())),
                    Vec3(0.4, 0.1, -0.2)};
  const auto field = fieldOf(transformed(boxMesh({0.2, 0.3, 0.1}), turned), kVoxel);
  const PrincipalFrame principal = principalFrame(field->cloud());
  EXPECT_NEAR((principal.frame.getOrigin() - v(0.4, 0.1, -0.2)).length(), 0, 0.02 * kVoxel);
  // Ascending: about y (0.3 long), x, z.
  const double wanted[] = {0.05 / 12, 0.10 / 12, 0.13 / 12};
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(principal.inertiaPerMass[axis], wanted[axis], 0.002 * wanted[axis]);
  EXPECT_NEAR(principal.frame.getBasis().determinant(), 1, 1e-4);
  const Vec3 longest = turned.orientation * Vec3::UnitY();
  EXPECT_NEAR(std::abs(principal.frame.getBasis().getColumn(0).dot(
                  v(longest.x(), longest.y(), longest.z()))),
              1, 1e-4);
}

// Bullet's margin of a cloud widens its bounds; the surface stays where it is, to the bit.
TEST(CloudShape, AMarginDoesNotMoveTheSurface) {
  btTransform places[2];
  for (const double margin : {0.0, 0.04}) {
    BulletWorld scene;
    scene.addGround();
    btRigidBody& ball = scene.addCloud(ballField(), 1, at({0, 0, btScalar(0.3)}));
    ball.getCollisionShape()->setMargin(btScalar(margin));
    for (int i = 0; i < 240; ++i) scene.step(1.0 / 240);
    places[margin > 0] = ball.getWorldTransform();
  }
  EXPECT_TRUE(places[0] == places[1]);
}

TEST(CloudShape, RefusesWhatItCannotDo) {
  CloudShape shape(ballField());
  EXPECT_THROW(CloudShape(nullptr), std::invalid_argument);
  EXPECT_EQ(shape.getShapeType(), CloudShape::kCloudType);
}

}  // namespace
}  // namespace cloudcontact::testing::shape_test
