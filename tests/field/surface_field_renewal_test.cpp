// A field renewed after cuts equals a newly built one to the bit.
#include <cloudcontact/field/surface_field.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <stdexcept>

#include <cloudcontact/voxels/digitize.h>

#include "mesh/thread_meshes.h"
#include "workpiece/cut_cases.h"

namespace cloudcontact::testing::surface_field_renewal_test {
namespace {

FieldSettings forCuts(int threads = 1) {
  FieldSettings settings;
  settings.threads = threads;
  settings.renewable = true;
  return settings;
}

void expectSame(const SurfaceField& renewedField, const SurfaceField& built, Random& random,
                const std::string& what) {
  ASSERT_EQ(renewedField.bandVoxels(), built.bandVoxels()) << what;
  ASSERT_EQ(renewedField.sampleCount(), built.sampleCount()) << what;
  for (std::size_t k = 0; k < built.sampleCount(); ++k) {
    const SurfaceSample a = renewedField.sample(k), b = built.sample(k);
    ASSERT_EQ(std::memcmp(&a, &b, sizeof a), 0) << what << ", sample " << k;
  }
  EXPECT_EQ(renewedField.bounds().min(), built.bounds().min()) << what;
  EXPECT_EQ(renewedField.bounds().max(), built.bounds().max()) << what;
  const Cloud& cloud = built.cloud();
  for (int k = 0; k < 2000; ++k) {
    const Vec3 at = cloud.origin() +
                    cloud.voxelSize() * random.inCube().cwiseProduct(cloud.size().cast<double>());
    const auto a = renewedField.at(at), b = built.at(at);
    ASSERT_EQ(a.has_value(), b.has_value()) << what << " at " << at.transpose();
    if (!a) continue;
    ASSERT_EQ(a->depth, b->depth) << what << " at " << at.transpose();
    ASSERT_EQ(a->normal, b->normal) << what << " at " << at.transpose();
  }
  EXPECT_EQ(renewedField.hash(), built.hash()) << what;
}

// Cuts of all kinds in sequence; each field is renewed from the previous one.
void cutAndCompare(Cloud cloud, std::uint64_t seed) {
  Random random(seed);
  auto field = SurfaceField::build(cloud, forCuts());
  for (int k = 0; k < 5; ++k) {
    const std::uint64_t before = field->hash();
    const Vec3 at = random.inCube().cwiseProduct(cloud.size().cast<double>());
    // Bites are centered at a sample, where there is material.
    const SurfaceSample s =
        field->sample(static_cast<std::size_t>(random.uniform() * double(field->sampleCount())));
    const Vec3 surface(s.position[0], s.position[1], s.position[2]);
    const std::string what = "cut " + std::to_string(k);
    const std::vector<VoxelCut> cuts = k == 2   ? specks(cloud, random, 20)
                                       : k == 3 ? sawn(cloud, at.x(), at.x() + 1.3)
                                                : bite(cloud, surface, random.uniform(0.7, 6));
    cloud = cutCloud(cloud, cuts).translated(Vec3(0.01, 0, -0.02));
    field = renewed(field, cloud, forCuts(1 + k % 2));
    expectSame(*field, *SurfaceField::build(cloud, forCuts()), random, what);
    if (::testing::Test::HasFatalFailure()) return;
    EXPECT_NE(field->hash(), before) << what;
  }
}

TEST(RenewedField, OfASphere) {
  cutAndCompare(cloudOf(ball({16.2, 16.4, 15.7}, 12.3), {4, 4, 4}), 1);
}
TEST(RenewedField, OfABox) {
  cutAndCompare(cloudOf(tiltedBox({20.2, 20.4, 20.7}, {14, 9, 7}), {5, 5, 5}), 2);
}
TEST(RenewedField, OfABoxAlongTheGrid) {
  cutAndCompare(
      cloudOf(
          [](const Vec3& p) { return ((p - Vec3(16, 16, 16)).cwiseAbs().array() < 12.25).all(); },
          {4, 4, 4}),
      3);
}
TEST(RenewedField, OfAToothShape) {
  cutAndCompare(cloudOf(tooth({20, 20, 22}), {5, 5, 5}), 4);
}
// Material up to the grid's own faces.
TEST(RenewedField, OfAFullGrid) {
  cutAndCompare(cloudOf([](const Vec3&) { return true; }, {3, 3, 3}), 5);
}

// Crests and roots 3 voxels apart, where the edge search takes all of its passes.
TEST(RenewedField, OfADigitizedThread) {
  const Pose turned{Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Vec3(1, 2, -1).normalized())),
                    Vec3::Zero()};
  DigitizeSettings settings;
  settings.voxelSize = 16e-3 / 26;
  settings.threads = 1;
  cutAndCompare(digitize(transformed(threadedRod(Thread{}, 16e-3), turned), settings), 6);
}

// A bar is sawn through: what is left of its field on either side is that of the piece alone.
TEST(RenewedField, OfThePiecesOfABar) {
  const Cloud bar = cloudOf(tiltedBox({48, 48, 48}, {40, 9, 7}), {12, 12, 12});
  const auto whole = SurfaceField::build(bar, forCuts());
  Random random(8);
  for (const double width : {1.4, 3.0, 17.0}) {
    const std::vector<Cloud> parts = pieces(cutCloud(bar, sawn(bar, 50, 50 + width)));
    ASSERT_EQ(parts.size(), 2u) << width;
    for (const Cloud& part : parts)
      expectSame(*renewed(whole, part, forCuts()), *SurfaceField::build(part, forCuts()), random,
                 "a saw of " + std::to_string(width) + " voxels");
  }
}

// A ball bur mills a groove in small steps; the edge searches are too few to keep up.
TEST(RenewedField, AfterManySmallCutsWithABudget) {
  Cloud cloud = cloudOf(tiltedBox({20.2, 16.4, 12.7}, {14, 9, 7}), {5, 4, 3});
  auto field = SurfaceField::build(cloud, forCuts());
  FieldSettings few = forCuts();
  few.edgeSearches = 5;
  std::size_t most = 0;
  for (int k = 0; k < 24; ++k) {
    cloud = cutCloud(cloud, bite(cloud, Vec3(8 + 0.8 * k, 16, 22), 5));
    const auto again = renewed(field, cloud, few);
    few.threads = 3 - few.threads;
    field = renewed(field, cloud, few);
    ASSERT_EQ(field->hash(), again->hash()) << "one thread and two, cut " << k;
    most = std::max(most, field->unsettled());
  }
  EXPECT_GT(most, 20u) << "the budget must bind for this to test";
  Random random(7);
  const auto built = SurfaceField::build(cloud, forCuts());
  expectSame(*renewed(field, cloud, forCuts()), *built, random, "all at once");
  int renewals = 0;
  while (field->unsettled() > 0 && renewals < 10000) {
    field = renewed(field, cloud, few);
    ++renewals;
  }
  EXPECT_GT(renewals, 10);
  expectSame(*field, *built, random, "little by little");
}

// Until it is settled, a field already has the depth of the cut, away from edges.
TEST(RenewedField, HasACutAtOnce) {
  const Cloud cloud =
      cloudOf([](const Vec3& p) { return p.z() < 16.3 && (p.array() > 2.2).all(); }, {5, 5, 3});
  FieldSettings few = forCuts();
  few.edgeSearches = 1;
  const Vec3 center(20, 20, 20);
  const Cloud after = cutCloud(cloud, bite(cloud, center, 9, 12));
  const auto field = renewed(SurfaceField::build(cloud, forCuts()), after, few);
  EXPECT_GT(field->unsettled(), 0u);
  for (const double depth : {-0.5, 0.0, 1.0, 3.0})
    for (const double angle : {-0.5, 0.0, 0.4}) {
      const Vec3 way(std::sin(angle), 0.1, -std::cos(angle));
      const Vec3 at = center + (9 + depth) * way.normalized();
      const auto point = field->at(cloud.origin() + cloud.voxelSize() * at);
      ASSERT_TRUE(point) << at.transpose();
      EXPECT_NEAR(point->depth / cloud.voxelSize(), depth, 0.1) << at.transpose();
      EXPECT_GT(point->normal.dot(-way.normalized()), 0.99) << at.transpose();
    }
}

TEST(BuiltField, IsTheSameForAnyNumberOfThreads) {
  const Cloud cloud = cloudOf(tooth({20, 20, 22}), {5, 5, 5});
  const std::uint64_t one = SurfaceField::build(cloud, forCuts(1))->hash();
  for (const int threads : {2, 3, 8})
    EXPECT_EQ(SurfaceField::build(cloud, forCuts(threads))->hash(), one) << threads;
}

TEST(RenewedField, OfACloudThatDidNotChange) {
  const Cloud cloud = cloudOf(ball({12, 12, 12}, 8), {3, 3, 3});
  const auto field = SurfaceField::build(cloud, forCuts());
  EXPECT_EQ(renewed(field, cloud)->hash(), field->hash());
}

// A renewal handles any change, not only cuts.
TEST(RenewedField, OfRestoredMaterial) {
  const Cloud whole = cloudOf(tooth({20, 20, 22}), {5, 5, 5});
  const auto first = SurfaceField::build(whole, forCuts());
  const auto cut = renewed(first, cutCloud(whole, bite(whole, {20, 14, 30}, 5)));
  ASSERT_NE(cut->hash(), first->hash());
  EXPECT_EQ(renewed(cut, whole)->hash(), first->hash());
}

TEST(RenewedField, IsBuiltIfTheOldOneIsNotRenewable) {
  const Cloud cloud = cloudOf(ball({12, 12, 12}, 8), {3, 3, 3});
  const auto plain = SurfaceField::build(cloud);
  const Cloud after = cutCloud(cloud, bite(cloud, {12, 12, 20}, 3));
  const auto field = renewed(plain, after);
  EXPECT_EQ(field->hash(), SurfaceField::build(after)->hash());
  EXPECT_GT(field->bytes(), plain->bytes()) << "the result is renewable";
}

TEST(RenewedField, RejectsOtherGridsAndEmptyClouds) {
  const Cloud cloud = cloudOf(ball({12, 12, 12}, 8), {3, 3, 3});
  const auto field = SurfaceField::build(cloud, forCuts());
  EXPECT_THROW(renewed(nullptr, cloud), std::invalid_argument);
  EXPECT_THROW(renewed(field, Cloud()), std::invalid_argument);
  EXPECT_THROW(renewed(field, cloudOf(ball({12, 12, 12}, 8), {3, 3, 4})), std::invalid_argument);
  EXPECT_THROW(renewed(field, cloudOf(ball({12, 12, 12}, 8), {3, 3, 3}, 2e-3)),
               std::invalid_argument);
  EXPECT_THROW(renewed(field, cutCloud(cloud, bite(cloud, {12, 12, 12}, 13))),
               std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::testing::surface_field_renewal_test
