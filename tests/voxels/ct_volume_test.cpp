// Bodies from CT values: a ball of three tissues, like a tooth, as a scanner measures it.
#include <gtest/gtest.h>

#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/voxels/ct_volume.h>

#include <cmath>
#include <limits>
#include <random>

namespace cloudcontact::ct_volume_test {
namespace {

constexpr double kVoxel = 2e-4;
const Vec3 kMiddle(20.3, 19.8, 20.1);  // [voxels]
constexpr double kOuter = 16.2, kDentin = 11.5, kPulp = 5;
const std::vector<CtRange> kRanges = {{-300, "pulp"}, {800, "dentin"}, {2100, "enamel"}};

// Each value is the mean over its cube plus noise.
CtVolume scan(double noise) {
  CtVolume v;
  v.size = Eigen::Vector3i::Constant(40);
  v.spacing.setConstant(kVoxel);
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 1);
  for (int k = 0; k < 64000; ++k) {
    const Vec3 corner(k % 40, k / 40 % 40, k / 1600);
    const double middle = (corner + Vec3::Constant(0.5) - kMiddle).norm();
    const bool pure = std::abs(middle - kPulp) > 1 && std::abs(middle - kDentin) > 1 &&
                      std::abs(middle - kOuter) > 1;
    const int n = pure ? 1 : 16;
    double sum = 0;
    for (int p = 0; p < n * n * n; ++p) {
      const Vec3 at = corner + Vec3(p % n + .5, p / n % n + .5, p / (n * n) + .5) / n;
      const double r = (at - kMiddle).norm();
      sum += r < kPulp ? 60 : r < kDentin ? 1500 : r < kOuter ? 2800 : -1000;
    }
    v.values.push_back(static_cast<float>(sum / (n * n * n) + noise * normal(random)));
  }
  return v;
}

TEST(CtVolume, SurfaceAndMaterials) {
  for (const double noise : {0.0, 30.0}) {
    const Cloud cloud = cloudFromCt(scan(noise), kRanges);
    const double r = kOuter * kVoxel, volume = 4 / 3.0 * M_PI * r * r * r;
    const MassProperties mass = cloud.massProperties();
    EXPECT_NEAR(mass.volume, volume, 0.01 * volume) << noise;
    EXPECT_NEAR((mass.centerOfMass - kVoxel * kMiddle).norm(), 0, 0.02 * kVoxel);
    ASSERT_EQ(cloud.materials().size(), 3u);
    std::size_t wrong = 0, enamelAtSurface = 0, surface = 0;
    for (int z = 0; z < cloud.size().z(); ++z)
      for (int y = 0; y < cloud.size().y(); ++y)
        for (int x = 0; x < cloud.size().x(); ++x) {
          if (cloud.coverage(x, y, z) == 0) continue;
          const double d = (cloud.center(x, y, z) / kVoxel - kMiddle).norm();
          const int truth = d < kPulp ? 0 : d < kDentin ? 1 : 2;
          const bool edge = std::abs(d - kPulp) < 1 || std::abs(d - kDentin) < 1;
          wrong += !edge && cloud.material(x, y, z) != truth;
          if (std::abs(d - kOuter) > 0.9) continue;
          ++surface;
          enamelAtSurface += cloud.material(x, y, z) == 2;
        }
    EXPECT_EQ(wrong, 0u) << "a half full voxel of enamel has the value of dentin";
    EXPECT_EQ(enamelAtSurface, surface);
    // The field sees a sphere.
    const auto field = SurfaceField::build(cloud);
    double worst = 0, sum = 0;
    for (std::size_t k = 0; k < field->sampleCount(); ++k) {
      const SurfaceSample s = field->sample(k);
      const Vec3 at = cloud.origin() / kVoxel + Vec3(s.position[0], s.position[1], s.position[2]);
      const double off = std::abs((at - kMiddle).norm() - kOuter);
      worst = std::max(worst, off), sum += off;
    }
    EXPECT_LT(worst, noise > 0 ? 0.3 : 0.05);
    EXPECT_LT(sum / static_cast<double>(field->sampleCount()), noise > 0 ? 0.03 : 0.01);
  }
}

TEST(CtVolume, ABodyEndsAtTheBorderOfTheScan) {
  CtVolume v;
  v.size = {8, 8, 8};
  v.spacing.setConstant(kVoxel);
  v.values.assign(512, 2000);
  const Cloud cloud = cloudFromCt(v, {{800, "bone"}});
  EXPECT_TRUE(cloud.materials().empty()) << "one material needs no names";
  EXPECT_NEAR(cloud.massProperties().volume, 512 * kVoxel * kVoxel * kVoxel, 1e-15);
}

TEST(CtVolume, RefusesBadInput) {
  CtVolume v = scan(0);
  EXPECT_THROW(cloudFromCt(v, {}), std::invalid_argument);
  EXPECT_THROW(cloudFromCt(v, {{800, "a"}, {800, "b"}}), std::invalid_argument);
  EXPECT_THROW(cloudFromCt(v, {{5000, "lead"}}), std::invalid_argument) << "all is air";
  EXPECT_THROW(cloudFromCt(v, kRanges, {0, 1000}), std::length_error);
  EXPECT_THROW(cloudFromCt(v, kRanges, {-1}), std::invalid_argument);
  v.values.pop_back();
  EXPECT_THROW(cloudFromCt(v, kRanges), std::invalid_argument);
  v.values.push_back(std::numeric_limits<float>::quiet_NaN());
  EXPECT_THROW(cloudFromCt(v, kRanges), std::invalid_argument);
  v = scan(0);
  v.spacing.z() = 0;
  EXPECT_THROW(cloudFromCt(v, kRanges), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::ct_volume_test
