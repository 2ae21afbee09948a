// One rule for hardness, (5'): a ball in the corner of a floor and a wall of different hardness is
// pushed the same way by a contact and by the haptic collision, and as sums made here say.
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/contact/paper_body.h>
#include <cloudcontact/workpiece/collision_finder.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <cloudcontact/voxels/digitize.h>
#include "contact/contact_cases.h"

namespace cloudcontact::testing::hardness_rule_test {
namespace {

constexpr double kVoxel = 1e-3, kRadius = 8 * kVoxel;

// The floor's top is z = 0, the wall's side x = 0.
Cloud corner() {
  const auto box = [](const Vec3& edges, const Vec3& middle) {
    return transformed(boxMesh(edges * kVoxel), {Eigen::Quaterniond::Identity(), middle * kVoxel});
  };
  DigitizeSettings settings;
  settings.voxelSize = kVoxel;
  return digitize(
      {{"floor", box({40, 30, 10}, {10, 0, -5})}, {"wall", box({10, 30, 20}, {-5, 0, 10})}},
      settings);
}

double degreesBetween(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / 3.14159265358979;
}

Vec3 byHand(const Cloud& cloud, const BaseVectorField& vectors, const double* h, const Vec3& ball) {
  Vec3 sum = Vec3::Zero();
  const Eigen::Vector3i size = cloud.size();
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x) {
        const double depth = (kRadius - (cloud.center(x, y, z) - ball).norm()) / kVoxel;
        sum += std::clamp(depth + 0.5, 0.0, 1.0) * cloud.coverage(x, y, z) *
               h[cloud.material(x, y, z)] * vectors.at({x, y, z}).toRepresentative;
      }
  return sum;
}

struct Table {
  double floor, wall;  // hardness [Pa]
  double h[2];
};

TEST(HardnessRule, IsOneForContactsAndHaptics) {
  const Cloud cloud = corner();
  const auto field = SurfaceField::build(cloud);
  const Vec3 ball = Vec3(7, 0.3, 6.5) * kVoxel;
  for (const Table& table : {Table{0, 3e9, {0, 1}},
                             {0, 3, {0, 1}},
                             {3e9, 0, {1, 0}},
                             {1e9, 3e9, {1, 3}},
                             {0, 0, {1, 1}}}) {
    const TissueTable tissues =
        tissuesOf({{"floor", 1e4, 1, table.floor, 1000}, {"wall", 1e4, 1, table.wall, 1000}},
                  cloud.materials());
    const PaperBody paper = paperBody(cloud, tissues);
    const Solid solid = Sphere{kRadius};
    ContactBody a, b;
    a.field = field.get(), a.tissues = &tissues, a.paper = &paper;
    b.shape = &solid, b.pose.position = ball;
    const Vec3 contact = wrenchOnB(ContactFinder().find(a, b, {}), {}, {}).force;
    Detection tool;
    tool.area = {solid, {}};
    CollisionFinder finder;
    const Vec3 haptic = finder.find(*paper.vectors, {}, tool, b.pose).mean;
    const Vec3 hand = byHand(cloud, *paper.vectors, table.h, ball);
    EXPECT_LT(degreesBetween(contact, haptic), 0.1) << table.floor << ", " << table.wall;
    EXPECT_LT(degreesBetween(contact, hand), 0.1) << table.floor << ", " << table.wall;
  }
}

}  // namespace
}  // namespace cloudcontact::testing::hardness_rule_test
