// Two springs in series against their complex stiffness, the stiffest spring of a step against its
// backward Euler motion, and the laws that have no state.
#include <cloudcontact/law/law.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <stdexcept>

namespace cloudcontact::law_test {
namespace {

TEST(InSeries, IsTheSlowLimitOfTwoSpringsWithDampers) {
  // 1 / (kA + i w cA) + 1 / (kB + i w cB) = 1 / (k + i w c) up to w^2.
  const KelvinVoigt a{2000, 3}, b{500, 7};
  const double w = 1e-3;
  using Complex = std::complex<double>;
  const Complex both =
      1. / (1. / Complex(a.stiffness, w * a.damping) + 1. / Complex(b.stiffness, w * b.damping));
  const auto pair = inSeries(a, b);
  ASSERT_TRUE(pair);
  EXPECT_NEAR(pair->stiffness, both.real(), 1e-9 * both.real());
  EXPECT_NEAR(pair->damping, both.imag() / w, 1e-9 * pair->damping);
  EXPECT_NEAR(pair->stiffness, 400, 1e-9);  // 2000 * 500 / 2500
}

TEST(InSeries, ABodyWithoutAMaterialIsRigid) {
  const KelvinVoigt a{2000, 3};
  EXPECT_EQ(inSeries(a, std::nullopt)->stiffness, 2000);
  EXPECT_EQ(inSeries(std::nullopt, a)->damping, 3);
  EXPECT_FALSE(inSeries(std::nullopt, std::nullopt));
  // The limit of a very stiff body.
  EXPECT_NEAR(inSeries(a, KelvinVoigt{1e12, 0})->stiffness, 2000, 1e-5);
  EXPECT_NEAR(inSeries(a, KelvinVoigt{1e12, 0})->damping, 3, 1e-5);
}

TEST(InSeries, TwoOfAKindAreHalfAsStiffAndHalfAsDamped) {
  const auto pair = inSeries(KelvinVoigt{800, 6}, KelvinVoigt{800, 6});
  EXPECT_DOUBLE_EQ(pair->stiffness, 400);
  EXPECT_DOUBLE_EQ(pair->damping, 3);
}

TEST(InSeries, TwoThatDoNotResistDoNotDivideByZero) {
  const auto pair = inSeries(KelvinVoigt{0, 0}, KelvinVoigt{0, 0});
  EXPECT_EQ(pair->stiffness, 0);
  EXPECT_EQ(pair->damping, 0);
}

TEST(Laws, AFoundationIsKelvinVoigtPerAreaAndRigidHasNoForce) {
  const LawState before{1e-3, 0};
  EXPECT_EQ(lawForce(Foundation{2e6, 30}, before, 2e-3, 0.01),
            lawForce(KelvinVoigt{2e6, 30}, before, 2e-3, 0.01));
  EXPECT_EQ(lawTangent(Foundation{2e6, 30}, before, 0, 0.01).grip,
            lawTangent(KelvinVoigt{2e6, 30}, before, 0, 0.01).grip);
  EXPECT_THROW(lawForce(Rigid{}, before, 2e-3, 0.01), std::invalid_argument);
  EXPECT_THROW(lawAdvance(Rigid{}, before, 2e-3, 0.01), std::invalid_argument);
}

TEST(Laws, PointsShareASpringOrALaw) {
  EXPECT_EQ(sharedSpring(KelvinVoigt{3, 2}).damping, 2);
  EXPECT_EQ(sharedSpring(Foundation{5, 4}).stiffness, 5);
  EXPECT_EQ(sharedSpring(Rigid{}).stiffness, 0);
  EXPECT_EQ(sharedSpring(Maxwell{7, 8}).stiffness, 1);
  EXPECT_EQ(sharedSpring(Maxwell{7, 8}).damping, 0);
}

TEST(StepLimited, PushesABodyOutWithinAFewStepsAndNeverPastTheSurface) {
  for (const double mass : {1e-4, 1.0, 500.0})
    for (const double step : {1. / 60, 1. / 240, 1e-3}) {
      const KelvinVoigt law = stepLimited(mass, step);
      double depth = 1, speed = 0;  // speed of sinking
      for (int i = 0; i < 20; ++i) {
        // Backward Euler: m (v+ - v) = -h (k (d + h v+) + c v+).
        speed = (mass * speed - step * law.stiffness * depth) /
                (mass + step * step * law.stiffness + step * law.damping);
        depth += step * speed;
        EXPECT_GT(depth, 0) << "overshot in step " << i;
        if (i == 9) {
          EXPECT_LT(depth, 0.02);
        }
      }
    }
}

TEST(StepLimited, HasDampingRatioOne) {
  const KelvinVoigt law = stepLimited(0.3, 1. / 120);
  EXPECT_NEAR(law.damping / (2 * std::sqrt(law.stiffness * 0.3)), 1, 1e-12);
}

TEST(StepLimited, RefusesBadInput) {
  EXPECT_THROW(stepLimited(0, 0.01), std::invalid_argument);
  EXPECT_THROW(stepLimited(1, 0), std::invalid_argument);
  EXPECT_THROW(stepLimited(INFINITY, 0.01), std::invalid_argument);
  EXPECT_THROW(stepLimited(1, NAN), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::law_test
