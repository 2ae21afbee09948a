// What a contact touches, by the runs of voxels that samples own, against sums made here over every
// voxel of both bodies. These look each voxel up in the other body by its public field or formula;
// they know no samples, runs, hits or patches.
#include "contact/touched_matter.h"

#include <cloudcontact/contact/paper_body.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "contact/contact_builder.h"
#include "contact/contact_cases.h"

namespace cloudcontact::testing::touched_matter_test {
namespace {

constexpr double kVoxel = 1e-3;

struct Sum {
  double n[2] = {}, k[2] = {};
  Vec3 f = Vec3::Zero();  // world

  double count() const { return n[0] + n[1]; }
};

// [m] In D, or the other body.
double depthIn(const ContactBody& other, const Vec3& world) {
  const Vec3 x = other.pose.toLocal(world);
  if (other.paper && other.paper->area) return depthOf(*other.paper->area, x);
  if (other.shape) return depthOf(PlacedSolid{*other.shape, {}}, x);
  if (const auto found = other.field->at(x)) return found->depth;
  const Cloud& cloud = other.field->cloud();
  const Eigen::Vector3i v = ((x - cloud.origin()) / cloud.voxelSize()).array().floor().cast<int>();
  return cloud.coverage(v.x(), v.y(), v.z()) > 127 ? 1 : -1;
}

void addByHand(const ContactBody& own, const ContactBody& other, int side, Sum& sum) {
  if (!own.field || !own.paper) return;
  const Cloud& cloud = own.field->cloud();
  const double h = cloud.voxelSize();
  const PaperBody& tool = other.paper ? *other.paper : *own.paper;
  const TissueTable& tissues = own.paper->vectors->tissues();
  const Eigen::Vector3i size = cloud.size();
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x) {
        const int coverage = cloud.coverage(x, y, z);
        if (coverage == 0) continue;
        const Vec3 at = own.pose.toWorld(cloud.center(x, y, z));
        const double depth = depthIn(other, at) / h;
        const double share = tool.membership == Membership::Whole
                                 ? (depth >= 0 ? 1 : 0)
                                 : std::clamp(depth + 0.5, 0.0, 1.0) * coverage / 255;
        if (!(share > 0)) continue;
        const int t = tissues.size() > 1 ? cloud.material(x, y, z) : 0;
        const double hard = own.paper->hardness ? tissues[std::size_t(t)].hardness : 1;
        sum.n[side] += share;
        sum.k[side] += share * tissues[std::size_t(t)].stiffness;
        sum.f += (side == 0 ? 1 : -1) * share * hard *
                 (own.pose.orientation * own.paper->vectors->at({x, y, z}).toRepresentative);
      }
}

Sum byHand(const ContactBody& a, const ContactBody& b) {
  Sum sum;
  addByHand(a, b, 0, sum);
  addByHand(b, a, 1, sum);
  return sum;
}

// What a query adds up over its patches.
Sum bySamples(const ContactBody& a, const ContactBody& b, std::size_t enough = 300) {
  const PairFrame frame = frameOf(a, b);
  HitSearch search;
  HitColumns hits;
  const int level = search.run(a, b, frame, 0, enough, hits);
  Binner binner;
  const double cell = cellOf(frame, level);
  binner.patches(hits, cell, a.shape || b.shape);
  TouchedMatter matter;
  Sum sum;
  for (const PatchMatter& m : matter.of(a, b, frame, search, {hits, binner, level, cell, 0})) {
    for (int side = 0; side < 2; ++side)
      sum.n[side] += m.count[side], sum.k[side] += m.stiffness[side];
    sum.f += frame.pose.orientation * m.vectors;
  }
  return sum;
}

double degreesBetween(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / 3.14159265358979;
}

struct Errors {
  std::vector<double> degrees, count;

  void add(const Sum& found, const Sum& truth) {
    degrees.push_back(degreesBetween(found.f, truth.f));
    count.push_back(std::abs(found.count() / truth.count() - 1));
  }
  static double mean(const std::vector<double>& all) {
    double sum = 0;
    for (const double x : all) sum += x / double(all.size());
    return sum;
  }
  static double at(std::vector<double> all, double share) {
    std::sort(all.begin(), all.end());
    return all[static_cast<std::size_t>(share * double(all.size() - 1))];
  }
};

// Every `step`-th of the contact cases, pressed and turned in the world, at every level of samples.
void compareCases(std::size_t step) {
  Errors all;
  const std::vector<ContactCase> cases = contactCases();
  for (std::size_t i = 0; i < cases.size(); i += step) {
    const ContactCase& one = cases[i];
    BodyMaker maker{kVoxel, Random(7)};
    const Instance pair = one.make(maker);
    PaperBody papers[2];
    const auto bodyAt = [&](const Body& body, const Pose& pose, PaperBody& paper) {
      ContactBody placed = body.at(pose);
      if (!body.field) return placed;
      if (!paper.vectors) paper = paperBody(body.field->cloud(), {});
      placed.paper = &paper;
      return placed;
    };
    Errors own;
    for (const double depth : {0.5, 1.0, 2.0}) {
      const Placed placed = pair.place(depth * kVoxel);
      const Pose world{maker.random.rotation(), Vec3(0.1, -0.2, 0.3)};
      const ContactBody a = bodyAt(pair.a, world * placed.a, papers[0]),
                        b = bodyAt(pair.b, world * placed.b, papers[1]);
      const Sum truth = byHand(a, b);
      if (truth.count() < 20) continue;  // a corner that hardly touches
      for (const std::size_t enough : {std::size_t{1}, std::size_t{300}, HitSearch::kAll}) {
        own.add(bySamples(a, b, enough), truth);
        all.add(bySamples(a, b, enough), truth);
      }
    }
    if (own.count.empty()) continue;
    EXPECT_LT(Errors::mean(own.degrees), 0.3) << one.name;
    EXPECT_LT(Errors::at(own.count, 1), 0.02) << one.name;
  }
  EXPECT_LT(Errors::mean(all.degrees), 0.1);
  EXPECT_LT(Errors::at(all.degrees, 0.95), 1);
  EXPECT_LT(Errors::mean(all.count), 0.002);
  EXPECT_LT(Errors::at(all.count, 0.95), 0.01);
}

TEST(TouchedMatter, IsTheSumOverVoxels) {
  compareCases(12);
}

TEST(TouchedMatter, IsTheSumOverVoxelsInAllCases) {
  compareCases(1);
}

// A round tooth of three tissues in shells of three voxels.
Cloud tooth(const Cloud& ball) {
  auto voxels = std::make_shared<Cloud::Voxels>(ball.voxels());
  voxels->materials = {"enamel", "dentin", "pulp"};
  voxels->materialTable.resize(voxels->table.size());
  const Vec3 middle = ball.massProperties().centerOfMass;
  for (std::size_t t = 0; t < voxels->table.size(); ++t) {
    voxels->materialTable[t] = static_cast<std::int32_t>(voxels->material.size());
    BrickMaterial& of = voxels->material.emplace_back();
    for (int cell = 0; cell < kBrickVoxels; ++cell) {
      const Eigen::Vector3i v = kBrickEdge * gridCell(t, voxels->bricks) + cellOffset(cell);
      const double r = (ball.center(v.x(), v.y(), v.z()) - middle).norm() / kVoxel;
      of[static_cast<std::size_t>(cell)] = r > 11 ? 0 : r > 9 ? 1 : 2;
    }
  }
  return Cloud(ball.voxelSize(), ball.origin(), voxels);
}

// Wherever a ball presses the tooth, as a solid or as a cloud: no voxel is lost, and (1) follows.
TEST(TouchedMatter, LosesNoVoxelOfATooth) {
  BodyMaker maker{kVoxel, Random(3)};
  const Body whole = maker.sphere(14), drill = maker.sphere(6);
  const Cloud cloud = tooth(whole.field->cloud());
  const auto field = SurfaceField::build(cloud);
  const TissueTable tissues = {
      {"enamel", 2e4, 8, 3e9, 2900}, {"dentin", 5e3, 4, 6e8, 2100}, {"pulp", 100, 1, 0, 1000}};
  const PaperBody paper = paperBody(cloud, tissues), ofDrill = paperBody(drill.field->cloud(), {});
  const Solid ball = Sphere{6 * kVoxel};
  Random random(11);
  const Vec3 middle = cloud.massProperties().centerOfMass;
  Errors errors;
  double worst = 0;
  for (int pose = 0; pose < 1000; ++pose) {
    ContactBody a, b;
    a.field = field.get(), a.tissues = &tissues, a.paper = &paper;
    a.pose = {random.rotation(), Vec3(0.01, 0.02, -0.01)};
    const double depth = random.uniform(0.3, 5);
    const Pose place{
        random.rotation(),
        a.pose.toWorld(middle) + (20 - depth) * kVoxel * (random.rotation() * Vec3::UnitX())};
    if (pose % 2) b = drill.at(place), b.paper = &ofDrill;
    if (pose % 2 == 0) b.shape = &ball, b.pose = place;
    const Sum truth = byHand(a, b), found = bySamples(a, b);
    errors.add(found, truth);
    worst = std::max(worst, std::abs(found.k[0] / found.n[0] / (truth.k[0] / truth.n[0]) - 1));
  }
  EXPECT_LT(Errors::at(errors.count, 1), 0.01);
  EXPECT_LT(worst, 0.01);
  EXPECT_LT(Errors::mean(errors.degrees), 0.1);
  EXPECT_LT(Errors::at(errors.degrees, 0.99), 1);
}

// D and membership choose the voxels, not the shape of the tool.
TEST(TouchedMatter, FollowsDAndMembership) {
  BodyMaker maker{kVoxel, Random(5)};
  const Body block = maker.box({24, 24, 16}), ball = maker.sphere(8);
  PaperBody ofBlock = paperBody(block.field->cloud(), {}),
            ofBall = paperBody(ball.field->cloud(), {});
  ContactBody a = block.at({}), b = ball.at({maker.random.rotation(), Vec3(1, 2, 14.5) * kVoxel});
  a.paper = &ofBlock, b.paper = &ofBall;
  const double usual = byHand(a, b).n[0];
  const Pose inBall = ball.grid.inverse();
  for (const double radius : {4.0, 8.0, 9.0})
    for (const Membership membership : {Membership::Shared, Membership::Whole}) {
      // Low in the ball, a small D still reaches the block.
      const Vec3 low = b.pose.toLocal(Vec3(1, 2, 14.5 - (8 - radius)) * kVoxel);
      ofBall.area = PlacedSolid{Sphere{radius * kVoxel}, {inBall.orientation, low}};
      ofBall.membership = membership;
      const Sum truth = byHand(a, b), found = bySamples(a, b);
      EXPECT_NEAR(found.n[0], truth.n[0], 1e-3 * truth.n[0]) << radius;
      EXPECT_NEAR(found.n[1], truth.n[1], 0.01 * truth.n[1]) << radius;
      EXPECT_LT(degreesBetween(found.f, truth.f), 0.3) << radius;
      if (radius < 8) {
        EXPECT_LT(truth.n[0], 0.8 * usual);
      } else if (radius > 8) {
        EXPECT_GT(truth.n[0], 1.05 * usual);
      }
    }
}

}  // namespace
}  // namespace cloudcontact::testing::touched_matter_test
