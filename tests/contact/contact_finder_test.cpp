// What the finder guarantees beside accuracy: shares of spring and damper, velocities, persistent
// IDs, reproducible bits, empty results and rejected input.
#include <gtest/gtest.h>

#include <cloudcontact/voxels/digitize.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <set>

#include "contact/contact_cases.h"

namespace cloudcontact::testing::contact_finder_test {
namespace {

constexpr double kVoxel = 1e-3;  // [m]

ContactSettings paper() {
  ContactSettings settings;
  settings.law = KelvinVoigt{2e4, 30};
  return settings;
}

class ContactFinderOn : public ::testing::TestWithParam<const char*> {
 protected:
  Instance instance() { return contactCase(GetParam()).make(maker_); }
  BodyMaker maker_{kVoxel, Random(31)};
  ContactFinder finder_;
};

std::string nameOf(const ::testing::TestParamInfo<const char*>& param) {
  return testName(param.param);
}

TEST_P(ContactFinderOn, DistributesOneSpringAndOneDamper) {
  const Instance pair = instance();
  for (const double depth : {0.3, 1.0}) {
    const ContactResult& found =
        findContact(finder_, pair, pair.place(depth * kVoxel), {}, paper());
    double stiffness = 0, damping = 0;
    for (const ContactPoint& point : found.points) {
      EXPECT_GT(point.stiffness, 0);
      stiffness += point.stiffness;
      damping += point.damping;
    }
    EXPECT_NEAR(stiffness, 2e4, 1e-6 * 2e4);
    EXPECT_NEAR(damping, 30, 1e-6 * 30);
  }
}

TEST_P(ContactFinderOn, PointsAreWithinTheOverlap) {
  const Instance pair = instance();
  const Placed placed = pair.place(0.6 * kVoxel);
  const ContactResult& found = findContact(finder_, pair, placed, {}, paper());
  ASSERT_FALSE(found.points.empty());
  for (const ContactPoint& point : found.points) {
    EXPECT_NEAR(point.normal.norm(), 1, 1e-6);
    // The bodies overlap by 0.6 at most; a slope adds to it at a patch's ends.
    EXPECT_LE(point.depth, 1.5 * kVoxel);
    EXPECT_GE(point.depth, 0);
    // Every case touches near z = 0, and its bodies are at most 61 voxels wide.
    EXPECT_LE(std::abs(point.position.z()), 1.5 * kVoxel);
    EXPECT_LE(point.position.head<2>().norm(), 45 * kVoxel);
    ASSERT_GE(point.patch, 0);
    ASSERT_LT(static_cast<std::size_t>(point.patch), found.patches.size());
  }
  for (const Patch& patch : found.patches) {
    EXPECT_LE(patch.points, 4);
    EXPECT_GE(patch.confidence, 0);
    EXPECT_LE(patch.confidence, 1);
  }
}

TEST_P(ContactFinderOn, DampsTheApproach) {
  const Instance pair = instance();
  const Placed placed = pair.place(0.6 * kVoxel);
  const ContactResult& found = findContact(finder_, pair, placed, {}, paper());
  const Wrench still = wrenchOnB(found, {}, {});
  Motion approach;
  approach.linear = -0.2 * Vec3::UnitZ();  // [m/s]
  const Wrench moving = wrenchOnB(found, {}, approach);
  // FR = k d + c v (paper, equation 3). The points' normals differ slightly.
  EXPECT_NEAR((moving.force - still.force).z(), 30 * 0.2, 0.03 * 30 * 0.2);
  Motion retreat;
  retreat.linear = 50 * Vec3::UnitZ();  // c v far beyond k d: contacts do not pull
  EXPECT_EQ(wrenchOnB(found, {}, retreat).force.norm(), 0);
}

TEST_P(ContactFinderOn, IdsPersistAndAreUnique) {
  const Instance pair = instance();
  const auto idsAt = [&](double depth) {
    std::set<std::uint32_t> ids;
    for (const ContactPoint& point :
         findContact(finder_, pair, pair.place(depth * kVoxel), {}, paper()).points) {
      EXPECT_TRUE(ids.insert(point.id).second) << "two points with ID " << point.id;
    }
    return ids;
  };
  const std::set<std::uint32_t> first = idsAt(0.6);
  EXPECT_EQ(idsAt(0.6), first);
  EXPECT_EQ(idsAt(0.601), first);
}

TEST_P(ContactFinderOn, RepeatsItsBits) {
  const Instance pair = instance();
  const Placed placed = pair.place(0.6 * kVoxel);
  ContactFinder other;
  findContact(other, pair, pair.place(0.9 * kVoxel), {}, {});  // earlier queries must not matter
  const ContactResult first = findContact(finder_, pair, placed, {}, paper());
  const ContactResult& again = findContact(other, pair, placed, {}, paper());
  ASSERT_EQ(first.points.size(), again.points.size());
  for (std::size_t k = 0; k < first.points.size(); ++k) {
    EXPECT_EQ(first.points[k].position, again.points[k].position);
    EXPECT_EQ(first.points[k].normal, again.points[k].normal);
    EXPECT_EQ(first.points[k].depth, again.points[k].depth);
  }
}

TEST_P(ContactFinderOn, IsEmptyForSeparateBodies) {
  const Instance pair = instance();
  for (const double gap : {1.0, 3.0, 1000.0}) {
    const Placed placed = pair.place(-gap * kVoxel);
    EXPECT_TRUE(findContact(finder_, pair, placed, {}, paper()).points.empty()) << gap;
  }
}

// With one spring for any area, a sliver of false overlap would push as hard as a face, and a body
// would hover on it. The force must be k d when pressed and zero when apart.
TEST_P(ContactFinderOn, ForceRisesFromZero) {
  const Instance pair = instance();
  const bool edge = std::string(GetParam()).find("edge") == 0;
  const double bound = edge ? 0.3 : 0.1;  // [voxels] of depth
  for (double depth = -0.8; depth <= 1.0; depth += 0.1) {
    const ContactResult& found =
        findContact(finder_, pair, pair.place(depth * kVoxel), {}, paper());
    const double force = wrenchOnB(found, {}, {}).force.norm() / (2e4 * kVoxel);
    EXPECT_NEAR(force, std::max(0.0, depth), bound)
        << "force over k in voxels, pressed by " << depth;
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, ContactFinderOn,
                         ::testing::Values("sphere16-halfspace", "sphere16-sphere40",
                                           "cylinder16-slab", "face-slab", "face-stack-aligned",
                                           "edge-slab", "primitive-sphere16", "plate3-slab"),
                         nameOf);

// An overhanging box also touches the table's wall, over a sliver. That patch must not be deep.
TEST(ContactFinderOverhang, NoPatchIsDeeperThanTheBodies) {
  ContactFinder finder;
  BodyMaker maker{kVoxel, Random(33)};
  for (const Law& law : {Law(KelvinVoigt{2e4, 30}), Law(Foundation{2e4, 30})}) {
    ContactSettings settings = paper();
    settings.law = law;
    for (const char* name : {"overhang", "overhang-aligned", "overhang-yawed"}) {
      const Instance pair = contactCase(name).make(maker);
      for (double x = -12; x <= 12; x += 1) {  // from all over the table to just off it
        Placed placed = pair.place(0.7 * kVoxel);
        placed.b.position.x() = x * kVoxel;
        for (const Patch& patch : findContact(finder, pair, placed, {}, settings).patches) {
          EXPECT_LE(patch.depth, 1.5 * kVoxel) << name << " at " << x << " voxels";
        }
      }
    }
  }
}

// Such bodies touched nothing, without a word.
TEST(ContactFinderInput, LengthsOfShapesAreValidated) {
  BodyMaker maker{kVoxel, Random(33)};
  const Body box = maker.box({10, 10, 10});
  ContactFinder finder;
  const auto meet = [&](const Solid& solid) {
    const Body shape = BodyMaker::shape(solid);
    finder.find(box.at({}), shape.at({}), {});
  };
  const double nan = std::nan("");
  for (const Solid& solid : std::initializer_list<Solid>{
           Sphere{-1}, Sphere{nan}, Box{{1, -1, 1}}, Ellipsoid{{1, 0, 1}}, Capsule{1, -1},
           Cylinder{-1, 1}, Cone{1, nan, 0}, Cone{1, 1, -1}, HalfSpace{{0, 0, nan}, 0}})
    EXPECT_THROW(meet(solid), std::invalid_argument) << "kind " << solid.index();
  for (const Solid& solid :
       std::initializer_list<Solid>{Sphere{0}, Box{{1, 0, 1}}, Capsule{1, 0}, Cylinder{1, 0}})
    EXPECT_NO_THROW(meet(solid)) << "kind " << solid.index() << ": Bullet has such shapes";
}

TEST(ContactFinderInput, IsValidated) {
  BodyMaker maker{kVoxel, Random(32)};
  const Body box = maker.box({10, 10, 10}), plane = BodyMaker::shape(HalfSpace{});
  ContactFinder finder;
  const ContactBody cloud = box.at({}), shape = plane.at({});
  EXPECT_THROW(finder.find(cloud, {}, {}), std::invalid_argument);
  EXPECT_THROW(finder.find({}, cloud, {}), std::invalid_argument);
  EXPECT_THROW(finder.find(shape, shape, {}), std::invalid_argument);
  ContactBody both = cloud;
  both.shape = shape.shape;
  EXPECT_THROW(finder.find(both, shape, {}), std::invalid_argument);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    ContactBody lost = cloud;
    lost.pose.position.y() = bad;
    EXPECT_THROW(finder.find(lost, shape, {}), std::invalid_argument);
    ContactBody spun = cloud;
    spun.pose.orientation.x() = bad;
    EXPECT_THROW(finder.find(shape, spun, {}), std::invalid_argument);
  }
  // A quaternion that is not of length 1 is no rotation: normals came out 178 long.
  ContactBody stretched = cloud;
  stretched.pose.orientation.coeffs() *= 1.01;
  EXPECT_THROW(finder.find(stretched, shape, {}), std::invalid_argument);
  stretched.pose.orientation.coeffs() *= (1 + 1e-5) / 1.01;
  EXPECT_NO_THROW(finder.find(stretched, shape, {}));
  for (const double bad : {std::nan(""), -0.01})
    EXPECT_THROW(finder.find(cloud, shape, {.margin = bad}), std::invalid_argument);
  EXPECT_THROW(finder.find(cloud, shape, {.samples = 0}), std::invalid_argument);
  EXPECT_THROW(finder.find(cloud, shape, {.law = KelvinVoigt{-1, 0}}), std::invalid_argument);
  EXPECT_NO_THROW(finder.find(cloud, shape, {})) << "a finder works after bad input";
}

// A depth that no float holds once overflowed the cells of hits (found by fuzzing). Beyond a
// thousand million voxels all depths are alike.
TEST(ContactFinderDepth, OfAnyBodyUnderGroundIsFinite) {
  BodyMaker maker{kVoxel, Random(34)};
  const Body box = maker.box({10, 10, 10}), plane = BodyMaker::shape(HalfSpace{});
  ContactFinder finder;
  for (const double down : {1.0, 1e6, 1e12, 1e38, 1e39, 1e188, 1e300}) {
    ContactBody under = box.at({});
    under.pose.position.z() = -down;
    const ContactResult& found = finder.find(under, plane.at({}), paper());
    ASSERT_FALSE(found.points.empty()) << down << " m";
    double depth = 0;  // that of the whole spring, whose shares add up to 1
    for (const ContactPoint& p : found.points) {
      depth += p.stiffness / 2e4 * p.depth;
      EXPECT_TRUE(p.position.allFinite()) << down << " m";
      EXPECT_NEAR(p.normal.z(), -1, 1e-6) << down << " m";
    }
    const double expected = std::min(down, 1e9 * kVoxel);
    EXPECT_NEAR(depth, expected, 0.01 * expected) << down << " m";
  }
}

// A shape's corner, edge, rim or tip pressed into a cloud's face along the grid, by up to four of
// the five voxels that the field reaches. The force stays k d. The cloud's samples alone would see
// 0.58 of a corner's depth.
struct Pressed {
  const char* name;
  Solid shape;
  Vec3 lowest;  // the point that enters first, in the shape's frame [voxels]
  Eigen::Quaterniond turn;
};

Eigen::Quaterniond down(const Vec3& direction) {
  return shortestTurn(direction.normalized(), -Vec3::UnitZ());
}

const Pressed kPressed[] = {
    {"corner", Box{Vec3(9, 10, 11) * kVoxel}, {9, 10, 11}, down({9, 10, 11})},
    {"edge", Box{Vec3(9, 10, 11) * kVoxel}, {9, 10, 0}, down({9, 10, 0})},
    {"even-edge", Box{Vec3(12, 12, 12) * kVoxel}, {12, 12, 0}, down({1, 1, 0})},
    {"rim", Cylinder{100 * kVoxel, 40 * kVoxel}, {100, 0, 40}, down({1, 0, 1})},
    {"tip", Cone{20 * kVoxel, 15 * kVoxel, 0}, {0, 0, 15}, down({0, 0, 1})}};

class DeepEdgeOf : public ::testing::TestWithParam<Pressed> {};

TEST_P(DeepEdgeOf, StaysLinear) {
  const Pressed& p = GetParam();
  DigitizeSettings digitizing;
  digitizing.voxelSize = kVoxel;
  const auto slab = SurfaceField::build(digitize(boxMesh(Vec3(80, 80, 24) * kVoxel), digitizing));
  ContactFinder finder;
  for (const double depth : {0.5, 1.0, 2.0, 3.0, 4.0}) {
    ContactBody a, b;
    a.field = slab.get();
    b.shape = &p.shape;
    b.pose = {p.turn, (Vec3(0.31, -0.17, 12 - depth) - p.turn * p.lowest) * kVoxel};
    const Wrench wrench = wrenchOnB(finder.find(a, b, paper()), {}, {});
    EXPECT_NEAR(wrench.force.z() / (2e4 * kVoxel), depth, 0.1) << p.name;
    EXPECT_LT(wrench.force.head<2>().norm(), std::sin(0.05) * wrench.force.norm()) << p.name;
  }
}
INSTANTIATE_TEST_SUITE_P(Shapes, DeepEdgeOf, ::testing::ValuesIn(kPressed),
                         [](const auto& shape) { return testName(shape.param.name); });

// A block of 48 voxels with this coverage inside, with all bricks stored as in a CT scan.
Cloud scannedBlock(std::uint8_t inside) {
  auto voxels = std::make_shared<Cloud::Voxels>();
  voxels->bricks = Eigen::Vector3i::Constant(8);
  for (int brick = 0; brick < 512; ++brick) {
    const Eigen::Vector3i low = 8 * Eigen::Vector3i(brick % 8, brick / 8 % 8, brick / 64);
    BrickCoverage coverage{};
    for (int v = 0; v < kBrickVoxels; ++v) {
      const Eigen::Vector3i at = low + Eigen::Vector3i(v % 8, v / 8 % 8, v / 64);
      if (at.minCoeff() >= 8 && at.maxCoeff() < 56) coverage[static_cast<std::size_t>(v)] = inside;
    }
    voxels->table.push_back(brick);
    voxels->coverage.push_back(coverage);
  }
  return Cloud(kVoxel, Vec3::Constant(-32 * kVoxel), voxels);
}

// Points far inside count as inside, whether their bricks are solid, stored, or slightly less than
// full.
TEST(ContactFinderDeep, InsideDoesNotDependOnStorage) {
  DigitizeSettings digitizing;
  digitizing.voxelSize = kVoxel;
  const auto box = SurfaceField::build(digitize(boxMesh(Vec3(10, 10, 10) * kVoxel), digitizing));
  ContactFinder finder;
  const auto forceOn = [&](const Cloud& cloud) {
    const auto block = SurfaceField::build(cloud);
    ContactBody a, b;
    a.field = block.get();
    b.field = box.get();
    b.pose.position = Vec3(0.3, 0.2, 24 + 5 - 9) * kVoxel;  // nine voxels deep, below the band
    return wrenchOnB(finder.find(a, b, paper()), {}, {}).force;
  };
  const Vec3 solid = forceOn(digitize(boxMesh(Vec3(48, 48, 48) * kVoxel), digitizing));
  EXPECT_GT(solid.z(), 0);
  for (const int inside : {255, 254}) {
    const Vec3 scanned = forceOn(scannedBlock(static_cast<std::uint8_t>(inside)));
    EXPECT_LT((scanned - solid).norm(), 0.03 * solid.norm()) << inside;
  }
}

}  // namespace
}  // namespace cloudcontact::testing::contact_finder_test
