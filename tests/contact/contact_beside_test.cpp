// Bodies that meet in one direction and are about to meet in another: a peg between two walls, over
// a floor. The near misses beside a touch tell the true gaps and leave the touch as it is.
#include <cloudcontact/contact/contact_finder.h>
#include <gtest/gtest.h>

#include "contact/contact_cases.h"
#include "contact/same_contact.h"

namespace cloudcontact::testing::contact_beside_test {
namespace {

constexpr double kVoxel = 1e-3, kMargin = 1.5 * kVoxel;
constexpr double kPeg = 16, kPlay = 0.6;  // [voxels] edge, and between it and both walls
constexpr double kFloor = 0.8;            // [voxels] between it and the floor
constexpr double kStep = 0.01;            // [s]
constexpr double kExact = 0.05 * kVoxel;

void add(const Mesh& part, const Vec3& shift, Mesh& mesh) {
  const int first = static_cast<int>(mesh.vertices.size());
  for (const Vec3& v : part.vertices) mesh.vertices.push_back(v + kVoxel * shift);
  for (const Eigen::Vector3i& t : part.triangles) mesh.triangles.emplace_back(t.array() + first);
}

// Two walls across x and a floor, apart from each other.
Mesh slotMesh() {
  Mesh slot;
  const double wall = kPeg / 2 + kPlay / 2 + 5;
  for (const double side : {-1.0, 1.0})
    add(boxMesh(kVoxel * Vec3(10, 40, 12)), Vec3(side * wall, 0, 2), slot);
  add(boxMesh(kVoxel * Vec3(10, 40, 8)), Vec3(0, 0, -kPeg / 2 - kFloor - 4), slot);
  return slot;
}

class Beside : public ::testing::Test {
 protected:
  BodyMaker maker{kVoxel, Random(5)};
  Body slot = maker.cloud(slotMesh()), peg = maker.box(Vec3(kPeg, 20, kPeg));
  const Pose world{maker.random.rotation(), maker.random.inCube()};

  // With the peg aside of the middle by `aside` [voxels].
  ContactResult found(double aside, double margin, bool beside = true, bool swapped = false) const {
    ContactBody a = slot.at(world), b = peg.at(world * Pose{Eigen::Quaterniond::Identity(),
                                                            Vec3(aside * kVoxel, 0, 0)});
    if (swapped) std::swap(a, b);
    ContactSettings settings;
    settings.margin = margin;
    ContactFinder finder;
    ContactResult found;
    finder.search(a, b, settings, found);
    if (beside) finder.lookBeside(a, b, settings, kStep, found);
    finder.giveIds(found);
    return found;
  }

  // The mean depth of the patches whose normal is `way`, in the slot's frame; NaN: there are none.
  double along(const ContactResult& contact, const Vec3& way) const {
    double sum = 0;
    int count = 0;
    for (const Patch& patch : contact.patches) {
      if ((world.orientation.conjugate() * patch.normal).dot(way) < 0.99) continue;
      sum += patch.depth;
      ++count;
    }
    return sum / count;
  }
};

TEST_F(Beside, AWallBehindAndAFloor) {
  const double touch = 0.1;  // voxels
  const ContactResult contact = found(kPlay / 2 + touch, kMargin);
  EXPECT_NEAR(along(contact, -Vec3::UnitX()), touch * kVoxel, kExact);
  EXPECT_NEAR(along(contact, Vec3::UnitX()), -(kPlay + touch) * kVoxel, kExact);
  EXPECT_NEAR(along(contact, Vec3::UnitZ()), -kFloor * kVoxel, kExact);
}

TEST_F(Beside, NothingTouches) {
  const ContactResult contact = found(0.15, kMargin);
  EXPECT_EQ(contact.samples, 0u);
  EXPECT_NEAR(along(contact, -Vec3::UnitX()), (0.15 - kPlay / 2) * kVoxel, kExact);
  EXPECT_NEAR(along(contact, Vec3::UnitX()), -(0.15 + kPlay / 2) * kVoxel, kExact);
}

TEST_F(Beside, BodiesSwapped) {
  const ContactResult contact = found(0.4, kMargin, true, true);
  EXPECT_NEAR(along(contact, Vec3::UnitX()), 0.1 * kVoxel, kExact);
  EXPECT_NEAR(along(contact, -Vec3::UnitX()), -0.7 * kVoxel, kExact);
}

TEST_F(Beside, NoFartherThanTheMargin) {
  const ContactResult contact = found(0.4, 0.6 * kVoxel);
  EXPECT_TRUE(std::isnan(along(contact, Vec3::UnitX())));
  EXPECT_TRUE(std::isnan(along(contact, Vec3::UnitZ())));
}

TEST_F(Beside, TheTouchStays) {
  const ContactResult alone = found(0.4, kMargin, false), contact = found(0.4, kMargin);
  ASSERT_GT(contact.patches.size(), alone.patches.size());
  EXPECT_EQ(depthOf(contact), depthOf(alone));
  EXPECT_EQ(contact.depthError, alone.depthError);
  for (std::size_t i = 0; i < alone.patches.size(); ++i) {
    EXPECT_EQ(contact.patches[i].depth, alone.patches[i].depth);
    EXPECT_EQ(contact.patches[i].stiffness, alone.patches[i].stiffness);
    EXPECT_FALSE(contact.patches[i].beside);
  }
  for (std::size_t i = alone.patches.size(); i < contact.patches.size(); ++i)
    EXPECT_TRUE(contact.patches[i].beside);
  const Wrench one = wrenchOnB(alone, {}, {}), other = wrenchOnB(contact, {}, {});
  EXPECT_EQ(one.force, other.force);
  EXPECT_EQ(one.torque, other.torque);
}

// A box on a larger one meets it in one direction only.
TEST_F(Beside, NothingElseIsNear) {
  const Body table = maker.box(Vec3(40, 40, 10)), box = maker.box(Vec3(12, 12, 12));
  ContactSettings settings;
  settings.margin = kMargin;
  ContactFinder finder;
  const ContactBody a = table.at({}),
                    b = box.at({Eigen::Quaterniond::Identity(), Vec3(0, 0, 10.9 * kVoxel)});
  ContactResult found;
  finder.search(a, b, settings, found);
  const std::size_t before = found.patches.size();
  ASSERT_GT(before, 0u);
  finder.lookBeside(a, b, settings, kStep, found);
  EXPECT_EQ(found.patches.size(), before);
}

// How many patches a body has that comes down on a table by 1.2 voxels a step, with what is beside.
std::size_t patchesOf(const Body& table, const Body& body, const Pose& pose) {
  ContactSettings settings;
  settings.margin = kMargin;
  const ContactBody a = table.at({});
  ContactBody b = body.at(pose);
  b.motion.linear.z() = -1.2 * kVoxel / kStep;
  ContactFinder finder;
  ContactResult found;
  finder.search(a, b, settings, found);
  EXPECT_EQ(found.patches.size(), 1u);
  finder.lookBeside(a, b, settings, kStep, found);
  return found.patches.size();
}

// What a wide face covers far from its four points is no patch of its own: its corners and its
// middle touch within the step with the rest of it.
TEST_F(Beside, AWideFaceIsOnePatch) {
  const Body table = maker.box(Vec3(60, 60, 10)), box = maker.box(Vec3(50, 40, 12));
  for (const double gap : {0.9, 0.3, -0.1})
    EXPECT_EQ(
        patchesOf(table, box, {Eigen::Quaterniond::Identity(), kVoxel * Vec3(0, 0, 11 + gap)}), 1u)
        << gap;
}

// Nor are the ends of a line.
TEST_F(Beside, ALongLineIsOnePatch) {
  const Body table = maker.box(Vec3(90, 60, 10)),
             rod = maker.cloud(cylinderMesh(10 * kVoxel, 70 * kVoxel, 1e-5));
  const Eigen::Quaterniond lying(Eigen::AngleAxisd(1.5707963267948966, Vec3::UnitY()));
  for (const double gap : {0.6, -0.1})
    EXPECT_EQ(patchesOf(table, rod, {lying, kVoxel * Vec3(0, 0, 15 + gap)}), 1u) << gap;
}

// A trial that serves takes the contact's place; one that does not leaves it as it was, with the
// points' IDs.
TEST_F(Beside, ATrialThatFindsNoTouchLeavesTheContact) {
  const Body table = maker.box(Vec3(40, 40, 10)), ball = maker.cloud(sphereMesh(8 * kVoxel, 1e-5));
  const auto at = [&](double x, double z) {
    return ball.at({Eigen::Quaterniond::Identity(), kVoxel * Vec3(x, 0, z)});
  };
  ContactSettings settings;
  settings.margin = kMargin;
  const ContactBody a = table.at({}), b = at(0, 12.95);
  ContactFinder finder, other;
  for (ContactFinder* each : {&finder, &other}) each->find(a, at(12, 12.95), settings);
  const ContactResult alone = other.find(a, b, settings);
  ASSERT_GT(alone.points.at(0).id, 0u);
  ContactResult found;
  finder.search(a, b, settings, found);
  EXPECT_FALSE(finder.searchTouch(a, at(0, 30), settings, found));
  finder.lookAround(a, b, settings, kVoxel * kVoxel, found);  // a ball is not broad
  finder.giveIds(found);
  expectSame(found, alone);
  EXPECT_TRUE(finder.searchTouch(a, at(0, 12), settings, found));
  expectSame(found, other.find(a, at(0, 12), settings), Ids::Ignored);
}

// A box that stands on one edge of its base, with the other edge above the table.
class Leaning : public ::testing::Test {
 protected:
  BodyMaker maker{kVoxel, Random(6)};
  Body table = maker.box(Vec3(60, 40, 10)), box = maker.box(Vec3(24, 12, 12));
  static constexpr double kTouch = 0.1, kGap = 0.8;  // [voxels]

  // What is beside the touch while the box turns about its edge, `closing` voxels down at the other
  // edge.
  std::vector<Patch> found(double closing) const {
    const double angle = std::asin((kTouch + kGap) / 24);
    Pose pose;
    pose.orientation = Eigen::AngleAxisd(angle, Vec3::UnitY());
    const Vec3 edge = pose.orientation * (kVoxel * Vec3(12, 0, -6));
    pose.position = Vec3(0, 0, (5 - kTouch) * kVoxel - edge.z());
    const ContactBody a = table.at({});
    ContactBody b = box.at(pose);
    b.motion = {Vec3::Zero(), Vec3(0, -closing / 24 / kStep, 0), pose.position + edge};
    ContactSettings settings;
    settings.margin = kMargin;
    ContactFinder finder;
    ContactResult found;
    finder.search(a, b, settings, found);
    EXPECT_GT(found.samples, 0u);
    finder.lookBeside(a, b, settings, kStep, found);
    std::vector<Patch> beside;
    for (const Patch& patch : found.patches)
      if (patch.beside) beside.push_back(patch);
    return beside;
  }
};

TEST_F(Leaning, TheOtherEdgeComesDown) {
  const std::vector<Patch> beside = found(1.2);
  ASSERT_FALSE(beside.empty());
  EXPECT_NEAR(beside.front().depth, -kGap * kVoxel, 0.1 * kVoxel);
  EXPECT_NEAR(beside.front().position.x(), -12 * kVoxel, 3 * kVoxel);
  EXPECT_GT(beside.front().normal.z(), 0.99);
}

// It comes down, but not within the step; or it goes up.
TEST_F(Leaning, TheOtherEdgeDoesNotTouch) {
  EXPECT_TRUE(found(0.4).empty());
  EXPECT_TRUE(found(0).empty());
  EXPECT_TRUE(found(-1.2).empty());
}

}  // namespace
}  // namespace cloudcontact::testing::contact_beside_test
