// Tips of pyramids and cones, pressed point first into a plane and into a cloud's face: at which
// depth contact begins, which depth is found, and whether the field claims material beside the tip.
// Compared with the geometry of the pyramid. Lengths in voxels.
#include <cloudcontact/contact/contact_finder.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <ostream>

#include "contact/contact_cases.h"

namespace cloudcontact::testing::surface_field_tips_test {
namespace {

constexpr double kVoxel = 1e-3;  // [m]
constexpr int kGrids = 5;        // each tip is digitized at this many grid directions and phases

struct Tip {
  int faces;
  double degrees;  // half angle, from the axis to a face
  // Largest delay of contact on any grid, and on average [voxels].
  double late, lateMean;
};
void PrintTo(const Tip& tip, std::ostream* out) {
  *out << tip.faces << " faces, " << tip.degrees << " deg";
}

double flank(const Tip& tip) {
  return tip.degrees * std::numbers::pi / 180;
}
double heightOf(const Tip& tip) {
  return tip.degrees > 20 ? 16 : 30;
}

// Point at the origin, axis along z, body above.
Mesh meshOf(const Tip& tip) {
  Mesh mesh;
  const double height = heightOf(tip) * kVoxel;
  const double corner = height * std::tan(flank(tip)) / std::cos(std::numbers::pi / tip.faces);
  mesh.vertices.emplace_back(0, 0, 0);
  for (int i = 0; i < tip.faces; ++i) {
    const double turn = 2 * std::numbers::pi * i / tip.faces;
    mesh.vertices.emplace_back(corner * std::cos(turn), corner * std::sin(turn), height);
  }
  for (int i = 0; i < tip.faces; ++i) {
    const int a = 1 + i, b = 1 + (i + 1) % tip.faces;
    mesh.triangles.emplace_back(0, b, a);
    if (i > 0 && i + 1 < tip.faces) mesh.triangles.emplace_back(1, a, b);
  }
  return mesh;
}

// Distance to the nearest face's plane, positive inside.
double trueDepth(const Tip& tip, const Vec3& x) {
  double depth = heightOf(tip) - x.z();
  for (int i = 0; i < tip.faces; ++i) {
    const double turn = 2 * std::numbers::pi * (i + 0.5) / tip.faces;
    const double out = x.x() * std::cos(turn) + x.y() * std::sin(turn);
    depth = std::min(depth, x.z() * std::sin(flank(tip)) - out * std::cos(flank(tip)));
  }
  return depth;
}

std::vector<Body> bodiesOf(const Tip& tip) {
  BodyMaker maker{kVoxel, Random(31)};
  std::vector<Body> bodies;
  for (int k = 0; k < kGrids; ++k) bodies.push_back(maker.cloud(meshOf(tip)));
  return bodies;
}

// The body that a tip is pressed into. Its face lies in the plane z = 0.
struct Wall {
  Body body;
  double half;
  Pose pose() const { return {Eigen::Quaterniond::Identity(), Vec3(0, 0, -half * kVoxel)}; }
};
Wall plane() {
  return {BodyMaker::shape(HalfSpace{}), 0};
}
Wall block() {
  BodyMaker maker{kVoxel, Random(32)};
  return {maker.box({24, 24, 10}), 5};
}

// Force over stiffness, in voxels: the pair's depth, for a contact along the normal.
double depthOf(ContactFinder& finder, const Body& tip, const Wall& wall, double press) {
  const ContactSettings settings;
  const Pose pose{Eigen::Quaterniond::Identity(), Vec3(0, 0, -press * kVoxel)};
  const ContactResult& found = finder.find(tip.at(pose), wall.body.at(wall.pose()), settings);
  return wrenchOnB(found, {}, {}).force.norm() / sharedSpring(settings.law).stiffness / kVoxel;
}

// The tip's true depth when the depth found first reaches 0.01 voxel.
double delayOf(ContactFinder& finder, const Body& tip, const Wall& wall) {
  double press = -1;
  while (press < 5 && depthOf(finder, tip, wall, press) < 0.01) press += 0.05;
  return press;
}

class FieldOfTip : public ::testing::TestWithParam<Tip> {};

TEST_P(FieldOfTip, TouchesAtItsPoint) {
  const Tip& tip = GetParam();
  ContactFinder finder;
  for (const Wall& wall : {plane(), block()}) {
    double mean = 0;
    for (const Body& body : bodiesOf(tip)) {
      const double late = delayOf(finder, body, wall);
      EXPECT_LE(late, tip.late);
      EXPECT_GE(late, -0.75);
      mean += late / kGrids;
    }
    EXPECT_LE(mean, tip.lateMean);
  }
}

TEST_P(FieldOfTip, IsAsDeepAsPressed) {
  const Tip& tip = GetParam();
  const Wall wall = plane();
  ContactFinder finder;
  for (const double press : {1.0, 2.0})
    for (const Body& body : bodiesOf(tip)) {
      const double depth = depthOf(finder, body, wall, press);
      EXPECT_GE(depth, press - tip.late - 0.1);
      EXPECT_LE(depth, press + 0.1);
    }
}

TEST_P(FieldOfTip, ClaimsNoMaterialBesideIt) {
  const Tip& tip = GetParam();
  Random random(33);
  int points = 0;
  double worst = -1e9;
  for (const Body& body : bodiesOf(tip))
    for (int drawn = 0; drawn < 20000; ++drawn) {
      const Vec3 at = Vec3(8, 8, 16).cwiseProduct(random.inCube()) - Vec3(4, 4, 4);
      if (trueDepth(tip, at) > -0.1) continue;
      const auto found = body.field->at(body.grid.toWorld(kVoxel * at));
      if (!found) continue;
      ++points;
      worst = std::max(worst, found->depth / kVoxel);
    }
  EXPECT_GT(points, 1000);
  EXPECT_LE(worst, 0.15);
}

std::string nameOf(const ::testing::TestParamInfo<Tip>& info) {
  return "faces" + std::to_string(info.param.faces) + "at" +
         std::to_string(std::lround(10 * info.param.degrees));
}

std::vector<Tip> tips() {
  std::vector<Tip> all;
  for (const int faces : {3, 4, 6})
    for (const double degrees : {8.0, 9.5, 11.3, 13.1, 18.4, 30.0, 45.0})
      all.push_back({faces, degrees, 0.45, 0.25});
  // Round tips have more faces than a voxel holds. Slender ones would touch up to two voxels late.
  for (const int faces : {8, 64})
    for (const double degrees : {30.0, 45.0}) all.push_back({faces, degrees, 0.45, 0.25});
  return all;
}

INSTANTIATE_TEST_SUITE_P(Tips, FieldOfTip, ::testing::ValuesIn(tips()), nameOf);

}  // namespace
}  // namespace cloudcontact::testing::surface_field_tips_test
