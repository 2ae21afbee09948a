// A body made in one line moves as mechanics says, and its mesh is where it was put.
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>
#include <cloudcontact/bullet/cloud_body.h>
#include <cloudcontact/voxels/digitize.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>

#include "bullet/bullet_world.h"
#include "bullet/convert.h"
#include "bullet/solid_meshes.h"

namespace cloudcontact::testing::cloud_body_test {
namespace {

constexpr double kArm = 0.12, kShortArm = 0.08, kThick = 0.03, kHeight = 0.04;

Mesh angle() {
  return angleMesh(kArm, kShortArm, kThick, kHeight);
}

btTransform somewhere() {
  return at({btScalar(0.3), btScalar(-0.2), btScalar(0.5)},
            btQuaternion(btVector3(1, 2, -1).normalized(), btScalar(0.7)));
}

Mesh shifted(const Mesh& mesh, const Vec3& by) {
  return transformed(mesh, {Eigen::Quaterniond::Identity(), by});
}

Cloud voxelsOf(const std::vector<NamedMesh>& parts) {
  DigitizeSettings settings;
  settings.voxelSize = 0.002;
  return digitize(parts, settings);
}

Vec3 sorted(Vec3 v) {
  std::sort(v.data(), v.data() + 3);
  return v;
}

Vec3 momentsOf(const btRigidBody& body) {
  return toVec3(body.getInvInertiaDiagLocal()).cwiseInverse();
}

// The inertia in world axes, from Bullet's diagonal and the body's transform.
Eigen::Matrix3d worldInertia(const btRigidBody& body) {
  const Eigen::Matrix3d turn = toPose(body.getWorldTransform()).orientation.toRotationMatrix();
  return turn * momentsOf(body).asDiagonal() * turn.transpose();
}

TEST(CloudBody, AnAngleHasTheMomentsOfItsBoxes) {
  constexpr double kDensity = 2700;
  const MassProperties wanted = matterOfBoxes(angleBoxes(kArm, kShortArm, kThick, kHeight));
  const CloudBody angled(angle(), somewhere(), {.densities = {kDensity}});
  const btRigidBody& body = angled.body();
  const double mass = 1 / double(body.getInvMass());
  EXPECT_NEAR(mass, kDensity * wanted.mass, 1e-3 * mass);
  const Pose place = toPose(somewhere());
  EXPECT_LT((toVec3(body.getCenterOfMassPosition()) - place.toWorld(wanted.centerOfMass)).norm(),
            1e-5);
  // As a tensor in the world, so that the axes count too.
  const Eigen::Matrix3d turn = place.orientation.toRotationMatrix();
  const Eigen::Matrix3d tensor = kDensity * turn * wanted.inertia * turn.transpose();
  EXPECT_LT((worldInertia(body) - tensor).norm(), 2e-3 * tensor.norm());
  EXPECT_GT(std::abs(wanted.inertia(0, 1)), 0.2 * wanted.inertia(0, 0));  // skew in its own axes
}

// Of a field or levels that are made already, in the mesh's frame: the same matter, and the same
// depth in a table.
TEST(CloudBody, FieldsThatAreMadeAlreadyAreShared) {
  DigitizeSettings how;
  how.voxelSize = kThick / 8;
  const Cloud cloud = digitize(angle(), how);
  const auto field = SurfaceField::build(cloud);
  const auto levels = std::make_shared<const FieldLevels>(cloud);
  const CloudBody made(cloud, somewhere(), {.mass = 2});
  const CloudBody given(field, somewhere(), {.mass = 2}), again(field, somewhere(), {.mass = 2}),
      coarser(levels, somewhere(), {.mass = 2, .fidelity = {1e-4}});
  EXPECT_EQ(&given.shape().field(), field.get());
  EXPECT_EQ(&again.shape().field(), field.get());
  const auto inertia = worldInertia(made.body());
  for (const CloudBody* const body : {&given, &again, &coarser}) {
    EXPECT_NEAR(1 / double(body->body().getInvMass()), 2, 1e-6);
    EXPECT_LT(toVec3(body->body().getCenterOfMassPosition() - made.body().getCenterOfMassPosition())
                  .norm(),
              1e-5);
    EXPECT_LT((worldInertia(body->body()) - inertia).norm(), 1e-4 * inertia.norm());
    EXPECT_LT((toPose(body->meshPlace()).position - toPose(somewhere()).position).norm(), 1e-5);
  }
  const CloudBody fixed(field, somewhere(), {.mass = 0});
  EXPECT_TRUE(fixed.body().isStaticObject());
  EXPECT_THROW(CloudBody(std::shared_ptr<const SurfaceField>()), std::invalid_argument);
  EXPECT_THROW(CloudBody(std::shared_ptr<const FieldLevels>()), std::invalid_argument);
}

TEST(CloudBody, AConesCenterIsAtAQuarterOfItsHeight) {
  constexpr double kRadius = 0.04, kTall = 0.1;
  const CloudBody cone(shifted(coneMesh(kRadius, kTall, 96), {1, 2, 3}), btTransform::getIdentity(),
                       {.mass = 3});
  const Vec3 center = toVec3(cone.body().getCenterOfMassPosition());
  EXPECT_LT((center - Vec3(1, 2, 3 + kTall / 4)).norm(), 2e-5);
  const double across = 3 * 3.0 / 80 * (4 * kRadius * kRadius + kTall * kTall);
  const Vec3 moments = sorted(momentsOf(cone.body()));
  EXPECT_NEAR(moments[0], 3 * 0.3 * kRadius * kRadius, 2e-3 * moments[0]);
  EXPECT_NEAR(moments[1], across, 2e-3 * across);
  EXPECT_NEAR(moments[2], across, 2e-3 * across);
}

// Two arms of different densities.
TEST(CloudBody, PartsWeighWhatTheirDensitiesSay) {
  const auto boxes = angleBoxes(kArm, kShortArm, kThick, kHeight);
  std::vector<NamedMesh> parts;
  for (const SolidBox& box : boxes)
    parts.push_back(
        {parts.empty() ? "steel" : "wood", shifted(boxMesh(box.high - box.low), box.center())});
  const Cloud cloud = voxelsOf(parts);
  const std::vector<std::string> names = cloud.materials();
  ASSERT_EQ(names.size(), 2u);
  std::vector<double> densities;
  TissueTable tissues;
  for (const std::string& name : names) {
    densities.push_back(name == "steel" ? 7800 : 600);
    tissues.push_back({name, 1e4, 1, 1, densities.back(), 0});
  }
  const double steel = 7800 * boxes[0].mass(), wood = 600 * boxes[1].mass();
  const Vec3 center = (steel * boxes[0].center() + wood * boxes[1].center()) / (steel + wood);
  const btTransform here = btTransform::getIdentity();
  const CloudBody one(parts, here, {.voxelSize = 0.002, .densities = densities});
  const CloudBody other(parts, here, {.voxelSize = 0.002, .tissues = tissues});
  for (const CloudBody* body : {&one, &other}) {
    EXPECT_NEAR(1 / double(body->body().getInvMass()), steel + wood, 2e-3 * steel);
    EXPECT_LT((toVec3(body->body().getCenterOfMassPosition()) - center).norm(), 1e-4);
  }
  EXPECT_EQ(other.shape().tissues().size(), 2u);
}

// By rays in the world: they meet the faces of the mesh, not those of the frame that was digitized.
TEST(CloudBody, TheMeshIsWhereItWasPut) {
  for (const double mass : {0.0, 1.0}) {
    BulletWorld scene;
    CloudBody body(angle(), somewhere(), {.voxelSize = 0.002, .mass = mass});
    body.addTo(scene.world);
    scene.world.updateAabbs();
    for (const Vec3& vertex : angle().vertices) {
      const btVector3 drawn =
          body.body().getWorldTransform() * (body.meshToBody() * toBullet(vertex));
      EXPECT_LT(drawn.distance(somewhere() * toBullet(vertex)), 1e-6);
      EXPECT_LT(
          (body.bodyToMesh() * (body.meshToBody() * toBullet(vertex))).distance(toBullet(vertex)),
          1e-6);
    }
    EXPECT_LT(body.meshPlace().getOrigin().distance(somewhere().getOrigin()), 1e-6);
    // Onto the long arm's side, its top, and the inner face of the short arm.
    const Vec3 rays[][3] = {{{0.09, -0.1, 0.02}, {0.09, 0.1, 0.02}, {0.09, 0, 0.02}},
                            {{0.09, 0.015, 0.2}, {0.09, 0.015, -0.2}, {0.09, 0.015, kHeight}},
                            {{0.1, 0.06, 0.02}, {-0.1, 0.06, 0.02}, {kThick, 0.06, 0.02}}};
    for (const auto& ray : rays) {
      const btVector3 from = somewhere() * toBullet(ray[0]), to = somewhere() * toBullet(ray[1]);
      btCollisionWorld::ClosestRayResultCallback hit(from, to);
      scene.world.rayTest(from, to, hit);
      ASSERT_TRUE(hit.hasHit());
      EXPECT_LT(hit.m_hitPointWorld.distance(somewhere() * toBullet(ray[2])), 2e-4) << mass;
    }
  }
}

// Euler's equations for a free body, with the closed form's moments, by Runge-Kutta.
Vec3 spunFreely(const Vec3& moments, Vec3 spin, double seconds) {
  const auto rate = [&](const Vec3& w) {
    return Vec3((moments[1] - moments[2]) * w[1] * w[2] / moments[0],
                (moments[2] - moments[0]) * w[2] * w[0] / moments[1],
                (moments[0] - moments[1]) * w[0] * w[1] / moments[2]);
  };
  constexpr int kSteps = 10000;
  const double h = seconds / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    const Vec3 a = rate(spin), b = rate(spin + h / 2 * a), c = rate(spin + h / 2 * b),
               d = rate(spin + h * c);
    spin += h / 6 * (a + 2 * b + 2 * c + d);
  }
  return spin;
}

// Heavy, because Bullet in float leaves the gyroscopic torque out where the product of the moments
// is below SIMD_EPSILON (btMatrix3x3::solve33).
TEST(CloudBody, TurnsFreelyAsEulerSays) {
  constexpr double kSeconds = 1;
  const MassProperties matter = matterOfBoxes(angleBoxes(kArm, kShortArm, kThick, kHeight));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(matter.inertia);
  BulletWorld scene;
  scene.world.setGravity({0, 0, 0});
  CloudBody body(angle(), somewhere(), {.mass = 500});
  body.addTo(scene.world);
  btRigidBody& rigid = body.body();
  rigid.setActivationState(DISABLE_DEACTIVATION);
  rigid.setDamping(0, 0);
  const Eigen::Matrix3d axes =
      toPose(somewhere()).orientation.toRotationMatrix() * principal.eigenvectors();
  const Vec3 spin = axes * Vec3(1, 4, 2);  // about the middle axis, which is unstable
  rigid.setAngularVelocity(toBullet(spin));
  const Vec3 momentum = worldInertia(rigid) * spin;
  const double step = 1e-3;
  for (int i = 0; i < int(kSeconds / step + 0.5); ++i) scene.step(step);
  const Vec3 after = toVec3(rigid.getAngularVelocity());
  EXPECT_LT((worldInertia(rigid) * after - momentum).norm(), 2e-3 * momentum.norm());
  const Vec3 wanted = spunFreely(principal.eigenvalues(), Vec3(1, 4, 2), kSeconds);
  EXPECT_NEAR(after.norm(), wanted.norm(), 5e-3 * wanted.norm());
  EXPECT_GT(std::abs(wanted.norm() - spin.norm()), 0.05);
  EXPECT_LT(
      (toVec3(rigid.getCenterOfMassPosition()) - toPose(somewhere()).toWorld(matter.centerOfMass))
          .norm(),
      2e-5);
}

// Thrown off its center, the mesh's corner goes the way of the analytic box's.
TEST(CloudBody, FallsAndTurnsAsBulletsBox) {
  const Vec3 edges(0.1, 0.06, 0.04), corner(0.7, -0.4, 0.2);  // of its mesh
  BulletWorld scene;
  CloudBody body(shifted(boxMesh(edges), corner + edges / 2), somewhere(), {.mass = 2});
  body.addTo(scene.world);
  btRigidBody& box = scene.add(std::make_unique<btBoxShape>(toBullet(Vec3(edges / 2))), 2,
                               somewhere() * at(toBullet(Vec3(corner + edges / 2))));
  scene.dispatcher.setNearCallback([](auto&...) {});
  for (btRigidBody* one : {&body.body(), &box}) {
    one->setActivationState(DISABLE_DEACTIVATION);
    one->setLinearVelocity({1, 2, 3});
    one->setAngularVelocity({3, -5, 2});
  }
  for (int i = 0; i < 240; ++i) scene.step(1.0 / 240);
  const btVector3 seen = body.meshPlace() * toBullet(corner);
  const btVector3 wanted = box.getWorldTransform() * toBullet(Vec3(-edges / 2));
  EXPECT_LT(seen.distance(wanted), 2e-4);
  EXPECT_GT(wanted.distance(somewhere() * toBullet(corner)), 1);
}

// With its weight as contact force, wherever the mesh's origin is, on fixed bodies of all kinds.
TEST(CloudBody, RestsWithItsWeight) {
  constexpr double kMass = 0.4, kStep = 1.0 / 240, kStiffness = 1e4;
  BulletWorld scene;
  CloudBody floor(shifted(boxMesh({0.4, 0.4, 0.05}), {5, 5, -0.025}), at({-5, -5, 0}),
                  {.voxelSize = 0.005, .mass = 0});
  floor.addTo(scene.world);
  EXPECT_TRUE(floor.body().isStaticObject());
  CloudBody body(shifted(angle(), {0.6, 0, 2}), at({btScalar(-0.65), 0, btScalar(-1.999)}),
                 {.mass = kMass, .law = KelvinVoigt{kStiffness, 20}});
  body.addTo(scene.world);
  body.body().setActivationState(DISABLE_DEACTIVATION);
  for (int i = 0; i < 480; ++i) scene.step(kStep);
  double force = 0;
  for (const btManifoldPoint& point : scene.points()) force += point.m_appliedImpulse / kStep;
  EXPECT_NEAR(force, kMass * 9.81, 1e-3 * kMass * 9.81);
  EXPECT_NEAR(body.meshPlace().getOrigin().z(), -2 - kMass * 9.81 / kStiffness, 5e-5);
  EXPECT_LT(body.body().getAngularVelocity().length(), 1e-4);
  EXPECT_TRUE(diagnose(scene.world).empty());
}

// Voxels that lie along no principal axis stay as they are, in a compound.
TEST(CloudBody, OfACloudMovesAsTheMeshDoes) {
  const MassProperties wanted = matterOfBoxes(angleBoxes(kArm, kShortArm, kThick, kHeight));
  const Cloud cloud = voxelsOf({{"", angle()}});
  const CloudBody made(cloud, somewhere(), {.mass = wanted.mass});
  EXPECT_TRUE(made.body().getCollisionShape()->isCompound());
  const Eigen::Matrix3d turn = toPose(somewhere()).orientation.toRotationMatrix();
  const Eigen::Matrix3d tensor = turn * wanted.inertia * turn.transpose();
  EXPECT_LT((worldInertia(made.body()) - tensor).norm(), 2e-3 * tensor.norm());
  EXPECT_LT(made.meshPlace().getOrigin().distance(somewhere().getOrigin()), 1e-6);
  BulletWorld scene;
  CloudBody fixed(cloud, somewhere(), {.mass = 0}), copy(made, somewhere());
  for (CloudBody* body : {&fixed, &copy}) {
    body->addTo(scene.world);
    scene.world.updateAabbs();
    const btVector3 from = somewhere() * toBullet(Vec3(0.09, 0.015, 0.2));
    const btVector3 to = somewhere() * toBullet(Vec3(0.09, 0.015, -0.2));
    btCollisionWorld::ClosestRayResultCallback hit(from, to);
    scene.world.rayTest(from, to, hit);
    ASSERT_TRUE(hit.hasHit());
    EXPECT_LT(hit.m_hitPointWorld.distance(somewhere() * toBullet(Vec3(0.09, 0.015, kHeight))),
              2e-4);
    body->leaveWorld();
    EXPECT_EQ(scene.world.getNumCollisionObjects(), 0);
  }
}

TEST(CloudBody, CopiesShareTheirVoxelsAndLeaveTheirWorld) {
  BulletWorld scene;
  const CloudBody first(angle(), somewhere(), {.mass = 2, .law = KelvinVoigt{1e4, 1}});
  std::vector<CloudBody> bodies;
  for (int i = 0; i < 3; ++i) {
    bodies.emplace_back(first, at({btScalar(i), 0, 0}));
    bodies.back().addTo(scene.world);
  }
  EXPECT_EQ(scene.world.getNumCollisionObjects(), 3);
  EXPECT_EQ(&bodies[2].shape().field(), &first.shape().field());
  EXPECT_TRUE(bodies[2].shape().law.has_value());
  EXPECT_EQ(bodies[2].body().getInvMass(), first.body().getInvMass());
  EXPECT_LT(bodies[2].meshPlace().getOrigin().distance({2, 0, 0}), 1e-6);
  EXPECT_EQ(bodies[2].world(), &scene.world);
  bodies.clear();
  EXPECT_EQ(scene.world.getNumCollisionObjects(), 0);
}

TEST(CloudBody, AMotionStateKnowsTheMesh) {
  btDefaultMotionState seen;
  BulletWorld scene;
  CloudBody body(angle(), somewhere(), {.mass = 1, .motionState = &seen});
  body.addTo(scene.world);
  EXPECT_LT(seen.m_graphicsWorldTrans.getOrigin().distance(somewhere().getOrigin()), 1e-6);
  body.body().setAngularVelocity({0, 0, 3});
  for (int i = 0; i < 60; ++i) scene.world.stepSimulation(btScalar(1.0 / 60), 1);
  scene.world.synchronizeMotionStates();
  EXPECT_LT(seen.m_graphicsWorldTrans.getOrigin().distance(somewhere().getOrigin()), 10);
  EXPECT_GT(seen.m_graphicsWorldTrans.getOrigin().distance(somewhere().getOrigin()), 4);
  // A moving platform: its user moves the mesh.
  body.body().setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
  seen.m_graphicsWorldTrans = at({1, 2, 3});
  scene.world.stepSimulation(btScalar(1.0 / 60), 1);
  EXPECT_LT(body.meshPlace().getOrigin().distance({1, 2, 3}), 1e-5);
  body.setMeshPlace(at({3, 2, 1}));
  EXPECT_LT(seen.m_graphicsWorldTrans.getOrigin().distance({3, 2, 1}), 1e-5);
}

std::string whyNot(const Mesh& mesh, const CloudBodySettings& settings = {},
                   const btTransform& place = btTransform::getIdentity()) {
  try {
    const CloudBody body(mesh, place, settings);
  } catch (const std::invalid_argument& why) {
    return why.what();
  }
  return "no error";
}

TEST(CloudBody, SaysWhatIsWrong) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const auto names = [](const std::string& why, const char* word) {
    EXPECT_NE(why.find(word), std::string::npos) << why;
  };
  names(whyNot(angle(), {.mass = -1.0}), "mass is -1");
  names(whyNot(angle(), {.mass = kNaN}), "mass is nan");
  names(whyNot(angle(), {.voxelSize = -0.1}), "voxelSize");
  names(whyNot(angle(), {.densities = {0}}), "density");
  names(whyNot(angle(), {.densities = {1, 2}}), "densities");
  names(whyNot(angle(), {.law = KelvinVoigt{-1, 0}}), "stiffness");
  names(whyNot(angle(), {}, at({btScalar(kNaN), 0, 0})), "place");
  for (const btMatrix3x3& basis :
       {btMatrix3x3(2, 0, 0, 0, 2, 0, 0, 0, 2), btMatrix3x3(-1, 0, 0, 0, 1, 0, 0, 0, 1),
        btMatrix3x3(1, btScalar(0.1), 0, 0, 1, 0, 0, 0, 1), btMatrix3x3(0, 0, 0, 0, 0, 0, 0, 0, 0),
        btMatrix3x3(btScalar(kNaN), 0, 0, 0, 1, 0, 0, 0, 1)})
    names(whyNot(angle(), {}, btTransform(basis)), "rigid");
  names(whyNot(angle(), {.mass = 1e-310}), "mass is 1e-310");  // has no inverse
  names(whyNot({}), "size");
  Mesh mesh = angle();
  mesh.vertices[3].y() = kNaN;
  names(whyNot(mesh), "vertex 3");
  mesh = angle();
  mesh.triangles[2][1] = 12;
  names(whyNot(mesh), "names vertex 12");
  mesh = angle();
  mesh.triangles.resize(2);
  names(whyNot(mesh), "shell()");
  mesh.triangles.clear();
  names(whyNot(mesh), "no triangles");
  EXPECT_EQ(whyNot(angle()), "no error");
  EXPECT_THROW(CloudBody{Cloud()}, std::invalid_argument);
}

// A lost triangle is closed, and told.
TEST(CloudBody, ReportsAnOpenMesh) {
  Mesh open = angle();
  open.triangles.pop_back();
  const CloudBody body(open), whole(angle());
  EXPECT_FALSE(body.report().closed);
  EXPECT_TRUE(whole.report().closed);
  EXPECT_NEAR(body.body().getInvMass(), whole.body().getInvMass(),
              2e-3 * whole.body().getInvMass());
}

}  // namespace
}  // namespace cloudcontact::testing::cloud_body_test
