// Contacts of shapes against closed forms, and their depth against a search over all directions.
#include "contact/shape_contact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "contact/press_direction.h"
#include "law/hulls.h"

namespace cloudcontact::testing::shape_contact_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kStiffness = 1000;  // [N/m]

ContactSettings settingsOf(double margin = 0) {
  ContactSettings settings;
  settings.law = KelvinVoigt{kStiffness, 0};
  settings.margin = margin;
  return settings;
}

ContactBody bodyOf(const Solid& solid, const Pose& pose = {}) {
  ContactBody body;
  body.shape = &solid;
  body.pose = pose;
  return body;
}

Eigen::Quaterniond turned(double angle, const Vec3& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized()));
}

// Lengths of about 1, voxels of 0.05.
constexpr double kVoxel = 0.05;
const Solid kGround = HalfSpace{Vec3::UnitZ(), 0};

// The contact, with force and torque about the world's origin.
struct Answer {
  ContactResult contact;
  Wrench onB;
};
Answer contactOf(const ContactBody& a, const ContactBody& b, double margin = 0) {
  Answer answer;
  EXPECT_TRUE(findShapes(a, b, settingsOf(margin), kVoxel, answer.contact));
  answer.onB = wrenchOnB(answer.contact, {}, {});
  return answer;
}

Vec3 pressureOf(const Answer& answer) {
  return answer.contact.patches.at(0).position;
}

// A shape lowered into the ground by d, as its lowest point tells.
struct Resting {
  const char* name;
  Solid solid;
  Eigen::Quaterniond turn;
  double height;  // of its center over its lowest point
  int points;
  double reach;  // root of the area's mean square about its middle, over both directions
  Vec3 pressed;  // center of pressure beside its center (x, y)
};

class ShapeOnGround : public ::testing::TestWithParam<Resting> {};

TEST_P(ShapeOnGround, PressesWithStiffnessTimesDepth) {
  const Resting& one = GetParam();
  for (const double d : {1e-3, 0.02}) {
    const Pose pose{one.turn, Vec3(3, -2, one.height - d)};
    const Answer answer = contactOf(bodyOf(kGround), bodyOf(one.solid, pose));
    ASSERT_EQ(answer.contact.patches.size(), 1u) << one.name;
    EXPECT_EQ(static_cast<int>(answer.contact.points.size()), one.points) << one.name;
    EXPECT_NEAR(answer.onB.force.z(), kStiffness * d, 1e-9) << one.name;
    EXPECT_NEAR(answer.contact.patches[0].depth, d, 1e-12) << one.name;
    const Vec3 at = Vec3(3, -2, -d / 2) + one.pressed;
    EXPECT_LE((pressureOf(answer) - at).norm(), 1e-9) << one.name << pressureOf(answer).transpose();
    EXPECT_LE((answer.onB.torque - at.cross(answer.onB.force)).norm(), 1e-9 * kStiffness)
        << one.name;
    double square = 0;
    for (const ContactPoint& p : answer.contact.points)
      square += (p.position - at).squaredNorm() / one.points;
    EXPECT_NEAR(std::sqrt(square), one.reach, 0.015 * one.reach + 1e-12) << one.name;
  }
}

// A round solid of radius 0.5 along z, 0.3 long to either side: touches with a line.
Resting onItsSide(const char* name, const Solid& solid) {
  return {name, solid, turned(kPi / 2, Vec3::UnitX()), 0.5, 2, 0.3 / std::sqrt(3.0), {0, 0, 0}};
}

const double kConeLean = std::atan2(0.5, 1.2);  // of its side from its axis
const Resting kResting[] = {{"ball", Sphere{0.7}, turned(1, {1, 2, 3}), 0.7, 1, 0, {0, 0, 0}},
                            {"box",
                             Box{{0.5, 0.3, 0.2}},
                             turned(0.4, Vec3::UnitZ()),
                             0.2,
                             4,
                             std::sqrt(0.34 / 3),
                             {0, 0, 0}},
                            {"cylinder on its end",
                             Cylinder{0.5, 0.3},
                             turned(kPi, Vec3::UnitX()),
                             0.3,
                             4,
                             0.5 / std::sqrt(2.0),
                             {0, 0, 0}},
                            onItsSide("cylinder on its side", Cylinder{0.5, 0.3}),
                            onItsSide("capsule on its side", Capsule{0.5, 0.3}),
                            {"cone on its base",
                             Cone{0.5, 0.6, 0},
                             turned(0, Vec3::UnitX()),
                             0.6,
                             4,
                             0.5 / std::sqrt(2.0),
                             {0, 0, 0}},
                            // Tipped about x so that its side lies on the ground: the side is 1.3
                            // long, its middle above the middle between tip and rim.
                            {"cone on its side",
                             Cone{0.5, 0.6, 0},
                             turned(kPi / 2 + kConeLean, Vec3::UnitX()),
                             0.6 * 0.5 / 1.3,
                             2,
                             0.65 / std::sqrt(3.0),
                             {0, 0.65 - 0.6 * 1.2 / 1.3, 0}}};

INSTANTIATE_TEST_SUITE_P(Shapes, ShapeOnGround, ::testing::ValuesIn(kResting));

// A box tipped about its edge: the wet part of its face is a wedge w long, and the force acts a
// third of it from the edge.
TEST(ShapeContact, TiltedBoxPressesWithItsEdge) {
  const Solid box = Box{{0.5, 0.3, 0.2}};
  const double tilt = 0.2, d = 0.01;
  const Eigen::Quaterniond turn = turned(tilt, Vec3::UnitY());
  const Vec3 edge = turn * Vec3(0.5, 0, -0.2);
  const Pose pose{turn, Vec3(0, 0, -edge.z() - d)};
  const Answer answer = contactOf(bodyOf(kGround), bodyOf(box, pose));
  EXPECT_NEAR(answer.onB.force.z(), kStiffness * d, 1e-9);
  const double wet = d / std::sin(tilt) * std::cos(tilt);
  EXPECT_NEAR(pressureOf(answer).x(), edge.x() - wet / 3, 1e-9);
  EXPECT_NEAR(pressureOf(answer).y(), 0, 1e-9);
  EXPECT_LE((answer.onB.torque - pressureOf(answer).cross(answer.onB.force)).norm(), 1e-9);
  EXPECT_NEAR(answer.contact.patches[0].area, wet * 0.6, 1e-9);
}

TEST(ShapeContact, OverhangingBoxPressesWhereBothAre) {
  const Solid table = Box{{1, 1, 0.5}}, box = Box{{0.4, 0.3, 0.2}};
  const Pose pose{turned(0, Vec3::UnitX()), Vec3(1.3, 0.2, 0.7 - 0.01)};
  const Answer answer = contactOf(bodyOf(table), bodyOf(box, pose));
  EXPECT_LE((answer.onB.force - Vec3(0, 0, kStiffness * 0.01)).norm(), 1e-9);
  EXPECT_LE((pressureOf(answer) - Vec3(0.95, 0.2, 0.495)).norm(), 1e-9);
  EXPECT_NEAR(answer.contact.patches[0].area, 0.1 * 0.6, 1e-12);
}

TEST(ShapeContact, CrossedEdgesPressAtTheirCrossing) {
  const Solid box = Box{{0.5, 0.5, 0.5}};
  const double half = 0.5 * std::sqrt(2.0), d = 0.01;
  const Eigen::Quaterniond onEdge = turned(kPi / 4, Vec3::UnitX());
  const Pose above{turned(kPi / 2, Vec3::UnitZ()) * onEdge, Vec3(0.1, -0.2, 2 * half - d)};
  const Answer answer = contactOf(bodyOf(box, {onEdge, Vec3::Zero()}), bodyOf(box, above));
  EXPECT_LE((answer.onB.force - Vec3(0, 0, kStiffness * d)).norm(), 1e-6 * kStiffness * d);
  EXPECT_LE((pressureOf(answer) - Vec3(0.1, 0, half - d / 2)).norm(), 2 * d);
}

TEST(ShapeContact, CrossedCylindersPressAtTheirCrossing) {
  const Solid rod = Cylinder{0.3, 1}, thick = Cylinder{0.4, 1};
  const double d = 0.01;
  const Pose below{turned(kPi / 2, Vec3::UnitX()), Vec3::Zero()};
  const Pose above{turned(kPi / 2, Vec3::UnitY()), Vec3(0.1, -0.2, 0.7 - d)};
  const Answer answer = contactOf(bodyOf(rod, below), bodyOf(thick, above));
  EXPECT_LE((answer.onB.force - Vec3(0, 0, kStiffness * d)).norm(), 1e-4 * kStiffness * d);
  EXPECT_LE((pressureOf(answer) - Vec3(0, -0.2, 0.3 - d / 2)).norm(), 1e-4);
}

TEST(ShapeContact, DeepBodiesAreLeftToClouds) {
  const Solid rod = Cylinder{0.5, 0.5};
  ContactResult found;
  const Pose inside{turned(1, {1, 2, 3}), Vec3(0.05, 0, 0.02)};
  EXPECT_FALSE(findShapes(bodyOf(rod), bodyOf(rod, inside), settingsOf(), kVoxel, found));
}

// The same forces, and the same points, whichever body is first.
TEST(ShapeContact, SwappedBodiesGiveTheOppositeForce) {
  const Solid box = Box{{0.5, 0.3, 0.2}}, rod = Cylinder{0.5, 0.3}, ball = Sphere{0.4},
              cone = Cone{0.5, 0.6, 0};
  const struct {
    const Solid &first, &second;
    Pose pose;
  } pairs[] = {
      {box, box, {turned(0.3, {0.1, 0.05, 1}), Vec3(0.1, 0.1, 0.39)}},
      {box, rod, {turned(0.02, {1, 0, 0}), Vec3(0.1, 0.1, 0.49)}},
      {box, rod, {turned(kPi / 2, {1, 0.3, 0}), Vec3(0.1, 0.1, 0.69)}},
      {rod, rod, {turned(0.4, {1, 2, 0.3}), Vec3(0.7, 0.1, 0.3)}},
      {cone, ball, {turned(0, {1, 0, 0}), Vec3(0.5, 0.3, 0)}},
  };
  for (const auto& pair : pairs) {
    const Answer one = contactOf(bodyOf(pair.first), bodyOf(pair.second, pair.pose), kVoxel);
    const Answer other = contactOf(bodyOf(pair.second, pair.pose), bodyOf(pair.first), kVoxel);
    ASSERT_EQ(one.contact.points.size(), other.contact.points.size());
    EXPECT_FALSE(one.contact.points.empty());
    EXPECT_LE((one.onB.force + other.onB.force).norm(), 1e-6 * one.onB.force.norm() + 1e-12);
    EXPECT_LE((one.onB.torque + other.onB.torque).norm(), 1e-6 * one.onB.force.norm() + 1e-12);
  }
}

TEST(ShapeContact, BodiesApartHaveTheirGap) {
  const Solid box = Box{{0.5, 0.3, 0.2}}, ball = Sphere{0.3};
  const Pose over{turned(0, Vec3::UnitX()), Vec3(0, 0, 0.21)};
  const Answer answer = contactOf(bodyOf(kGround), bodyOf(box, over), kVoxel);
  ASSERT_EQ(answer.contact.points.size(), 4u);
  for (const ContactPoint& p : answer.contact.points) {
    EXPECT_NEAR(p.depth, -0.01, 1e-12);
    EXPECT_NEAR(p.position.z(), 0.005, 1e-12);
  }
  EXPECT_TRUE(contactOf(bodyOf(kGround), bodyOf(box, over), 0.005).contact.points.empty());
  const Answer single = contactOf(
      bodyOf(kGround), bodyOf(ball, {turned(1, Vec3::UnitX()), Vec3(0, 0, 0.32)}), kVoxel);
  ASSERT_EQ(single.contact.points.size(), 1u);
  EXPECT_NEAR(single.contact.points[0].depth, -0.02, 1e-12);
}

// Random pairs of all kinds that overlap by a little or are a little apart.
class RandomPairs {
 public:
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Solid solid(int kind) {
    switch (kind) {
      case 0:
        return Sphere{between(0.3, 1)};
      case 1:
        return Box{Vec3(between(0.3, 1), between(0.3, 1), between(0.3, 1))};
      case 2:
        return Capsule{between(0.3, 0.6), between(0.3, 1)};
      case 3:
        return Cylinder{between(0.3, 1), between(0.3, 1)};
      case 4:
        return Cone{between(0.5, 1), between(0.5, 1), 0};
      default:
        return test::randomHull(8, between(0.3, 1), random_);
    }
  }
  Vec3 direction() {
    Vec3 v;
    do v = Vec3(between(-1, 1), between(-1, 1), between(-1, 1));
    while (v.norm() > 1 || v.norm() < 0.1);
    return v.normalized();
  }
  Eigen::Quaterniond turn() { return turned(between(0, kPi), direction()); }
  int kind() { return std::uniform_int_distribution<int>(0, 5)(random_); }

 private:
  std::mt19937 random_{11};
};

double along(const PlacedConvex& a, const PlacedConvex& b, const Vec3& n) {
  return n.dot(a.support(n) - b.support(-n));
}

// The least depth over all directions: a grid of them, then a pattern search.
double leastDepth(const PlacedConvex& a, const PlacedConvex& b, int kStarts) {
  constexpr int kGrid = 1500;
  std::vector<std::pair<double, Vec3>> tried;
  for (int i = 0; i < kGrid; ++i) {
    const double z = 1 - (2 * i + 1.0) / kGrid, r = std::sqrt(1 - z * z);
    const double angle = kPi * (3 - std::sqrt(5.0)) * i;
    const Vec3 n(r * std::cos(angle), r * std::sin(angle), z);
    tried.emplace_back(along(a, b, n), n);
  }
  std::partial_sort(tried.begin(), tried.begin() + kStarts, tried.end(),
                    [](const auto& x, const auto& y) { return x.first < y.first; });
  double all = 1e300;
  for (int start = 0; start < kStarts; ++start) {
    auto [least, best] = tried[static_cast<std::size_t>(start)];
    for (double step = 0.05; step > 1e-6;) {
      const Vec3 u = best.unitOrthogonal(), v = best.cross(u);
      const double before = least;
      for (int k = 0; k < 24; ++k) {
        const double angle = 2 * kPi * k / 24 + 1e3 * step;
        const Vec3 n = (best + step * (std::cos(angle) * u + std::sin(angle) * v)).normalized();
        if (const double depth = along(a, b, n); depth < least) least = depth, best = n;
      }
      if (least == before) step *= 0.6;
    }
    all = std::min(all, least);
  }
  return all;
}

TEST(ShapeContact, DepthIsTheLeastOverAllDirections) {
  RandomPairs pairs;
  for (int trial = 0; trial < 220; ++trial) {
    const int kinds[2] = {pairs.kind(), pairs.kind()};
    const Solid first = pairs.solid(kinds[0]), second = pairs.solid(kinds[1]);
    PlacedConvex a{&first, pairs.turn().toRotationMatrix(), Vec3::Zero()};
    PlacedConvex b{&second, pairs.turn().toRotationMatrix(), 5 * pairs.direction()};
    // Moves B until it overlaps by `wanted` along the way to A.
    const double wanted = pairs.between(0, 0.03);
    for (int k = 0; k < 6; ++k) b.at += (leastDepth(a, b, 1) - wanted) * b.at.normalized();
    const double least = leastDepth(a, b, 12);
    const auto press = pressDirection(a, b);
    ASSERT_TRUE(press) << trial;
    // Never less, as every direction's depth is an upper bound.
    EXPECT_GE(press->depth, least - 2e-4) << trial;
    EXPECT_NEAR(press->depth, along(a, b, press->normal), 1e-9) << trial;
    const bool rimOnHull = std::minmax(kinds[0], kinds[1]).second == 5 &&
                           (kinds[0] + kinds[1] == 8 || kinds[0] + kinds[1] == 9);
    EXPECT_LE(press->depth, least + (rimOnHull ? 2e-3 : 1e-3))
        << trial << ": " << kinds[0] << ' ' << kinds[1];
  }
}

// A box by its planes and corners is answered as the box is, though not by the box's formulas.
TEST(ShapeContact, HullOfABoxIsTheBox) {
  RandomPairs pairs;
  const Vec3 half(0.5, 0.35, 0.2);
  const Solid box = Box{half}, hull = test::boxHull(half);
  int met = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const int kind = trial % 6;
    const bool onGround = trial % 7 == 0;
    const Solid other = onGround ? kGround : kind == 5 ? box : pairs.solid(kind);
    // Faces that are nearly parallel, and any pose.
    const Eigen::Quaterniond turn =
        trial % 2 == 0 ? pairs.turn() : turned(pairs.between(0, 0.02), pairs.direction());
    PlacedConvex a{&box, Eigen::Matrix3d::Identity(), Vec3::Zero()};
    PlacedConvex b{&other, turn.toRotationMatrix(), 5 * pairs.direction()};
    Pose pose{turn, b.at};
    if (onGround) {
      pose.position = Vec3(0, 0, 0);
      pose.position = turn * Vec3(0, 0, -1) * (a.reach(turn * Vec3(0, 0, -1)) - 0.01);
    } else {
      for (int k = 0; k < 6; ++k) b.at += (leastDepth(a, b, 1) - 0.01) * b.at.normalized();
      pose.position = b.at;
    }
    ContactResult contact;
    Wrench onOther[2];
    int found = 0;
    for (const Solid* body : {&box, &hull}) {
      if (!findShapes(bodyOf(*body), bodyOf(other, pose), settingsOf(), kVoxel, contact)) break;
      onOther[found] = wrenchOnB(contact, {}, {});
      ++found;
    }
    if (found < 2) continue;  // an edge beside a face: clouds answer
    const double force = onOther[0].force.norm();
    met += force > 0;
    // Between rims and edges both have a direction that is nearly the best.
    const bool rim = !onGround && (kind == 3 || kind == 4);
    const bool faces = kind == 1 || kind == 5;  // of two that are nearly parallel either is right
    const double off = rim ? 0.3 : faces ? 0.021 : 1e-6;
    EXPECT_LE((onOther[0].force - onOther[1].force).norm(), off * force) << trial << ' ' << kind;
    EXPECT_LE((onOther[0].torque - onOther[1].torque).norm(), off * force) << trial << ' ' << kind;
  }
  EXPECT_GE(met, 250);
}

// A face of more corners than a feature holds, and a long prism on its edge.
TEST(ShapeContact, PrismsRestOnTheirFacesAndEdges) {
  const double d = 0.01;
  const Solid many = test::prismHull(40, 0.5, 0.3);
  const Answer flat = contactOf(bodyOf(kGround), bodyOf(many, {{}, Vec3(0, 0, 0.3 - d)}));
  ASSERT_EQ(flat.contact.points.size(), 4u);
  EXPECT_NEAR(flat.onB.force.z(), kStiffness * d, 1e-9);
  EXPECT_NEAR(flat.contact.patches[0].area, kPi * 0.25, 0.03 * kPi * 0.25);
  EXPECT_LE(flat.onB.torque.norm(), 5e-4 * kStiffness * d);  // 16 corners of 40
  const Solid rod = test::prismHull(6, 0.2, 1);
  const Eigen::Quaterniond lies = turned(kPi / 2, Vec3::UnitY());
  const double edge = 0.2 / std::cos(kPi / 6);
  const Pose pose{lies * turned(kPi / 6, Vec3::UnitZ()), Vec3(0, 0, edge - d)};
  const Answer onFace = contactOf(bodyOf(kGround), bodyOf(rod, {lies, Vec3(0, 0, 0.2 - d)}));
  const Answer onEdge = contactOf(bodyOf(kGround), bodyOf(rod, pose));
  EXPECT_NEAR(onFace.onB.force.z(), kStiffness * d, 1e-9);
  EXPECT_NEAR(onEdge.onB.force.z(), kStiffness * d, 1e-9);
  // One of both faces presses, in a strip along the edge.
  EXPECT_NEAR(onEdge.onB.torque.norm(), kStiffness * d * d / std::tan(kPi / 6) / 3, 1e-6);
}

}  // namespace
}  // namespace cloudcontact::testing::shape_contact_test
