// ContactResult::pointed: what a body stands on, and how much faster than by the points' slopes the
// force moves between its feet as the body turns.
#include <cloudcontact/contact/contact_finder.h>
#include <gtest/gtest.h>

#include "contact/contact_cases.h"
#include "field/mesh_field.h"
#include "mesh/feet_meshes.h"

namespace cloudcontact::testing::pointed_contact_test {
namespace {

constexpr double kVoxel = 5e-3, kX = 0.2, kY = 0.15, kHigh = 0.06;

struct Foot {
  const char* name;
  Mesh mesh;  // its lowest places are at z = 0
  double pointed;
};

std::vector<Foot> feet() {
  Pose up;
  up.position.z() = kHigh;
  return {{"post", transformed(boxMesh({kHigh, kHigh, 2 * kHigh}), up), 0},
          {"ball", transformed(sphereMesh(kHigh, 1e-4), up), 1},
          {"tip", test::tipMesh(kHigh), 2}};
}

// The contact of a body that stands on four feet, turned about x and pressed in by `depth` [m].
ContactResult standing(const SurfaceField& body, double depth, double turn) {
  static const Solid ground = HalfSpace{Vec3::UnitZ(), 0};
  ContactBody above{}, below{};
  above.field = &body;
  above.pose.position.z() = -depth;
  above.pose.orientation = Eigen::AngleAxisd(turn, Vec3::UnitX());
  below.shape = &ground;
  ContactSettings settings;
  settings.law = KelvinVoigt{1e4, 0};
  ContactFinder finder;
  return finder.find(above, below, settings);
}

// About the x axis through the origin, of the points' forces.
double momentOf(const ContactResult& contact) {
  double sum = 0;
  for (const ContactPoint& p : contact.points)
    sum -= p.stiffness * p.depth * p.position.cross(p.normal).x();
  return sum;
}

TEST(PointedContact, IsThatOfTheFeet) {
  for (const Foot& foot : feet()) {
    const auto body = fieldOf(test::feetMesh(foot.mesh, kX, kY), kVoxel);
    EXPECT_NEAR(standing(*body, 0.8 * kVoxel, 0).pointed, foot.pointed, 0.15) << foot.name;
  }
}

// Of posts the moment grows as the slopes say, of balls twice, of tips three times as fast.
TEST(PointedContact, ForceMovesBetweenFeetFasterThanBySlopes) {
  for (const Foot& foot : feet()) {
    const auto body = fieldOf(test::feetMesh(foot.mesh, kX, kY), kVoxel);
    const double depth = 0.8 * kVoxel, turn = 0.05 * kVoxel / kY;
    const ContactResult one = standing(*body, depth, turn), other = standing(*body, depth, -turn);
    double bySlopes = 0;
    for (const ContactPoint& p : one.points) bySlopes += p.slope * p.position.y() * p.position.y();
    const double grows = std::abs(momentOf(one) - momentOf(other)) / (2 * turn);
    EXPECT_NEAR(grows / bySlopes, 1 + foot.pointed, 0.1 * (1 + foot.pointed)) << foot.name;
  }
}

}  // namespace
}  // namespace cloudcontact::testing::pointed_contact_test
