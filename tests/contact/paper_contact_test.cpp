// Contacts by the paper's method: direction (5'), k and c (1), (2), and force (3), (6), against
// sums made here by hand over every voxel, and against the laws of symmetry.
#include <cloudcontact/contact/paper_body.h>
#include <cloudcontact/voxels/digitize.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <string>

#include "contact/contact_cases.h"

namespace cloudcontact::testing::paper_contact_test {
namespace {

constexpr double kVoxel = 1e-3;
constexpr double kRadius = 8 * kVoxel;

TissueTable steelAndRubber() {
  return {{"steel", 4e4, 10, 8e9, 7800}, {"rubber", 1e4, 40, 1e9, 1100}};
}

// A block of 32 x 24 x 16 voxels, its top at z = 0: steel where x < 0, rubber beyond.
Cloud twoBlock() {
  const auto half = [](double x) {
    return transformed(boxMesh(Vec3(16, 24, 16) * kVoxel),
                       {Eigen::Quaterniond::Identity(), Vec3(x, 0, -8) * kVoxel});
  };
  DigitizeSettings settings;
  settings.voxelSize = kVoxel;
  return digitize({{"steel", half(-8)}, {"rubber", half(8)}}, settings);
}

struct TwoBlock {
  Cloud cloud = twoBlock();
  std::shared_ptr<const SurfaceField> field = SurfaceField::build(cloud);
  TissueTable tissues = tissuesOf(steelAndRubber(), cloud.materials());
  PaperBody paper = paperBody(cloud, tissues);

  ContactBody body() const {
    ContactBody b;
    b.field = field.get();
    b.tissues = &tissues;
    b.paper = &paper;
    return b;
  }
};

const TwoBlock& twoTissues() {
  static const TwoBlock kBlock;
  return kBlock;
}

// Sums over all voxels of the block, one by one.
struct ByHand {
  double n = 0, k = 0, c = 0;
  Vec3 f = Vec3::Zero();
};

ByHand byHand(const TwoBlock& block, const Vec3& ball) {
  ByHand sum;
  const Eigen::Vector3i size = block.cloud.size();
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x) {
        const double depth = kRadius - (block.cloud.center(x, y, z) - ball).norm();
        const double share =
            std::clamp(depth / kVoxel + 0.5, 0.0, 1.0) * block.cloud.coverage(x, y, z) / 255;
        if (!(share > 0)) continue;
        const Tissue& t = block.tissues[block.cloud.material(x, y, z)];
        sum.n += share;
        sum.k += share * t.stiffness;
        sum.c += share * t.damping;
        sum.f += share * t.hardness / block.tissues[0].hardness *
                 block.paper.vectors->at({x, y, z}).toRepresentative;
      }
  return sum;
}

double degreesBetween(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / 3.14159265358979;
}

class BallOverASeam : public ::testing::TestWithParam<double> {};

TEST_P(BallOverASeam, FollowsTheEquations) {
  const TwoBlock& block = twoTissues();
  const double depth = 2 * kVoxel;
  const Vec3 place(GetParam() * kVoxel, 0.3 * kVoxel, kRadius - depth);
  const ByHand hand = byHand(block, place);
  const Solid ball = Sphere{kRadius};
  ContactBody b;
  b.shape = &ball;
  b.pose.position = place;
  ContactSettings settings;
  settings.law = KelvinVoigt{1, 0};
  ContactFinder finder;
  const ContactResult& found = finder.find(block.body(), b, settings);
  ASSERT_FALSE(found.points.empty());
  double k = 0, c = 0;
  for (const ContactPoint& p : found.points) k += p.stiffness, c += p.damping;
  EXPECT_NEAR(k, hand.k / hand.n, 0.01 * hand.k / hand.n);
  EXPECT_NEAR(c, hand.c / hand.n, 0.01 * hand.c / hand.n);
  const Wrench onB = wrenchOnB(found, {}, {});
  EXPECT_LT(degreesBetween(onB.force, hand.f), 0.5);
  EXPECT_NEAR(onB.force.norm(), hand.k / hand.n * depth, 0.03 * hand.k / hand.n * depth);
  // The force acts where the bodies touch.
  const Vec3 touched = place - Vec3(0, 0, kRadius - depth / 2);
  const Vec3 about = onB.torque - touched.cross(onB.force);
  EXPECT_LT(about.norm() / onB.force.norm(), kVoxel);
}

INSTANTIATE_TEST_SUITE_P(Places, BallOverASeam, ::testing::Values(-6.0, -2.0, -0.5, 0.0, 0.4, 3.0));

// Where nothing is stated, the tissues count likewise.
TEST(Tissues, CountWhereNothingIsStated) {
  const TwoBlock& block = twoTissues();
  const Solid ball = Sphere{kRadius};
  for (const double x : {-4.0, 0.0, 0.7, 5.0}) {
    ContactBody b;
    b.shape = &ball;
    b.pose.position = Vec3(x, 0, 6) * kVoxel;
    const ByHand hand = byHand(block, b.pose.position);
    ContactFinder finder;
    ContactBody a = block.body();
    a.paper = nullptr;
    const ContactResult& found = finder.find(a, b, ContactSettings{});
    double k = 0;
    for (const ContactPoint& p : found.points) k += p.stiffness;
    EXPECT_NEAR(k, hand.k / hand.n, 0.01 * hand.k / hand.n) << x;
  }
}

// Two clouds: swapped, turned with the world, and scaled, the contact is the same.
TEST(PaperContact, HasTheSymmetriesOfSpace) {
  const TwoBlock& block = twoTissues();
  BodyMaker maker{kVoxel, Random(5)};
  const Body ball = maker.sphere(8);
  const PaperBody ballPaper = paperBody(ball.field->cloud(), {});
  const Pose place{Eigen::Quaterniond::Identity(), Vec3(1, 2, 6.5) * kVoxel};
  ContactBody a = block.body(), b = ball.at(place);
  b.paper = &ballPaper;
  ContactSettings settings;
  ContactFinder finder, swapped, turned;
  const Wrench straight = wrenchOnB(finder.find(a, b, settings), {}, {});
  const Wrench back = wrenchOnB(swapped.find(b, a, settings), {}, {});
  const double size = straight.force.norm();
  EXPECT_GT(size, 0);
  EXPECT_LT((straight.force + back.force).norm(), 1e-6 * size);
  EXPECT_LT((straight.torque + back.torque).norm(), 1e-6 * size * kRadius);
  const Pose world{Random(3).rotation(), Vec3(0.3, -0.2, 0.1)};
  a.pose = world * a.pose;
  b.pose = world * b.pose;
  const Wrench seen = wrenchOnB(turned.find(a, b, settings), {}, {});
  EXPECT_LT((seen.force - world.orientation * straight.force).norm(), 1e-4 * size);
}

struct Tool {
  const char* name;
  Mesh mesh;
  Solid solid;
  Eigen::Quaterniond turn;  // its tip down
  double reach;             // from its center to the tip [voxels]
};

std::vector<Tool> tools() {
  const double h = kVoxel;
  const auto straight = Eigen::Quaterniond::Identity();
  const Eigen::Quaterniond edge(Eigen::AngleAxisd(std::acos(0.0) / 2, Vec3::UnitX()));
  const auto corner = shortestTurn(Vec3::Ones(), -Vec3::UnitZ());
  const Vec3 cube = Vec3::Constant(6 * h), blade = Vec3(8, 1.25, 8) * h;
  return {{"needle", cylinderMesh(1.5 * h, 16 * h, 1e-6), Cylinder{1.5 * h, 8 * h}, straight, 8},
          {"blade", boxMesh(2 * blade), Box{blade}, straight, 8},
          {"corner", boxMesh(2 * cube), Box{cube}, corner, 6 * std::sqrt(3.0)},
          {"edge", boxMesh(2 * cube), Box{cube}, edge, 6 * std::sqrt(2.0)},
          {"face", boxMesh(2 * cube), Box{cube}, straight, 6},
          {"ball", sphereMesh(8 * h, 1e-6), Sphere{8 * h}, straight, 8}};
}

// Step 3: the depth is how far the tool's tip is in, whatever its shape, as a solid and as a cloud.
class Press {
 public:
  // How far off the depth is [voxels], for a tip that is in by `depth` [voxels].
  double error(const Tool& tool, const Body& body, const PaperBody* paper, double depth) const {
    const Eigen::Quaterniond odd(Eigen::AngleAxisd(0.4, Vec3::UnitZ()));
    ContactBody a = block_.at({});
    a.paper = &paper_;
    ContactBody b = body.at({odd * tool.turn, Vec3(0.3, 0.2, 12 + tool.reach - depth) * kVoxel});
    b.paper = paper;
    ContactSettings settings;
    settings.law = KelvinVoigt{1, 0};
    ContactFinder finder;
    const Wrench wrench = wrenchOnB(finder.find(a, b, settings), {}, {});
    return std::abs(wrench.force.norm() / kVoxel - depth);
  }

  BodyMaker maker{kVoxel, Random(4)};

 private:
  const Body block_ = maker.box({40, 40, 24}, true);
  const PaperBody paper_ = paperBody(block_.field->cloud(), {});
};

constexpr double kDepths[] = {1, 2, 4};  // [voxels]

TEST(PaperContact, IsAsDeepAsTheToolGoes) {
  const Press press;
  for (const Tool& tool : tools())
    for (const double depth : kDepths)
      EXPECT_LT(press.error(tool, BodyMaker::shape(tool.solid), nullptr, depth),
                std::min(0.1, 0.03 * depth))
          << tool.name;
}

// A cloud's grid has a random place and turn. Some round a needle of three voxels, which is then up
// to 0.23 off: the mean of several counts.
TEST(PaperContact, CloudsAreAsDeepInTheMean) {
  constexpr int kGrids = 8;
  Press press;
  for (const Tool& tool : tools()) {
    double mean[std::size(kDepths)] = {};
    for (int grid = 0; grid < kGrids; ++grid) {
      const Body cloud = press.maker.cloud(tool.mesh);
      const PaperBody paper = paperBody(cloud.field->cloud(), {});
      for (std::size_t k = 0; k < std::size(kDepths); ++k)
        mean[k] += press.error(tool, cloud, &paper, kDepths[k]) / kGrids;
    }
    const double bound = tool.name == std::string("needle") ? 0.15 : 0.04;
    for (std::size_t k = 0; k < std::size(kDepths); ++k)
      EXPECT_LT(mean[k], bound) << tool.name << " at " << kDepths[k];
  }
}

TEST(PaperContact, NeedsBaseVectorsOfItsCloud) {
  const TwoBlock& block = twoTissues();
  ContactBody a = block.body(), b = a;
  BodyMaker maker{kVoxel, Random(5)};
  const PaperBody none, other = paperBody(maker.sphere(8).field->cloud(), {});
  for (const PaperBody* const wrong : {&none, &other}) {
    b.paper = wrong;
    EXPECT_THROW(ContactFinder().find(a, b, {}), std::invalid_argument);
  }
  PaperSettings noAbility;
  noAbility.ability = 0;
  EXPECT_THROW(paperBody(block.cloud, block.tissues, noAbility), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::testing::paper_contact_test
