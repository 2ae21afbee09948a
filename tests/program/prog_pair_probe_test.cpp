// `contact` reports what Bullet gets: the finder's points and those in Bullet's manifolds of the
// same pair are equal and carry the same law.
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/contact/contact_finder.h>
#include <gtest/gtest.h>

#include "scene/body.h"
#include "scene/bullet_methods.h"
#include "scene/pair_probe.h"

namespace prog_pair_probe_test {
namespace {

using namespace cloudcontact;
using namespace cloudcontact::program;

std::shared_ptr<const SurfaceField> fieldOf(const std::string& specification, double voxel) {
  CommonOptions options;
  options.voxel = voxel;
  const Body body = readBody(specification, options);
  return buildField(digitizeBody(body, voxel, options).cloud, specification, options);
}

struct Sum {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double stiffness = 0;
};

Sum sumOf(const std::vector<ProbedPoint>& points) {
  Sum sum;
  for (const ProbedPoint& p : points) {
    const Vec3 force = p.stiffness * std::max(0.0, p.depth) * p.normal;
    sum.force += force;
    sum.torque += p.position.cross(force);
    sum.stiffness += p.stiffness;
  }
  return sum;
}

TEST(PairProbe, BulletsManifoldsHoldTheFindersContact) {
  const double voxel = 0.001;
  const auto box = fieldOf("box:0.03,0.03,0.02", voxel), sphere = fieldOf("sphere:0.016", voxel);
  CloudShape boxShape(box), sphereShape(sphere);
  for (CloudShape* const shape : {&boxShape, &sphereShape}) shape->setFidelity({0, 0, true});
  Pose pose;
  pose.position = Vec3(0.004, -0.003, 0.0254);
  pose.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));

  ContactFinder finder;
  ContactBody a, b;
  a.field = box.get();
  b.field = sphere.get();
  b.pose = pose;
  const ContactSettings settings{KelvinVoigt{2500, 7}};
  const ContactResult& truth = finder.find(a, b, settings);
  const Wrench wrench = wrenchOnB(truth, {}, {});
  ASSERT_GT(wrench.force.z(), 1);  // 0.6 voxels deep

  PairProbe probe(boxShape, sphereShape, pose, {}, Method::Cloud, {settings.law});
  const std::vector<ProbedPoint> points = probe.points();
  EXPECT_EQ(points.size(), truth.points.size());
  const Sum sum = sumOf(points);
  EXPECT_NEAR(sum.stiffness, 2500, 1);
  EXPECT_LT((sum.force - wrench.force).norm(), 1e-3 * wrench.force.norm());
  EXPECT_LT((sum.torque - wrench.torque).norm(), 1e-5 * wrench.force.norm());
}

TEST(PairProbe, TimesEveryCallAndForgetsNothingBetween) {
  btSphereShape small(btScalar(0.02));
  btStaticPlaneShape plane(btVector3(0, 0, 1), 0);
  Pose pose;
  pose.position = Vec3(0, 0, 0.0199);
  PairProbe probe(plane, small, pose, {}, Method::Primitive, {});
  const auto before = probe.points();
  const std::vector<double> times = probe.microseconds(25, 1e-6);
  EXPECT_EQ(times.size(), 25U);
  for (const double t : times) EXPECT_GE(t, 0);
  const auto after = probe.points();
  ASSERT_EQ(before.size(), 1U);
  ASSERT_EQ(after.size(), 1U);
  EXPECT_NEAR(before[0].depth, 0.0001, 1e-7);
  EXPECT_EQ(before[0].depth, after[0].depth);
}

}  // namespace

}  // namespace prog_pair_probe_test
