// The automatic spring against its definition: the own weight sags by a tenth of a voxel, stiffness
// is the force's derivative, and no path in and out, in Bullet's steps, gains energy.
#include <cloudcontact/law/automatic_spring.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace cloudcontact::automatic_spring_test {
namespace {

constexpr double kVoxel = 0.01, kGravity = 9.81, kSteps[] = {1. / 60, 1. / 240, 1e-3};

TEST(AutomaticSpring, OwnWeightSagsByATenthOfAVoxelWithinTheStepsLimit) {
  for (const double step : kSteps)
    for (const double voxel : {1e-4, 1e-2, 0.2}) {
      const AutomaticSpring spring = automaticSpring(2, 2 * kGravity, voxel, step);
      const double limit = stepLimited(2, step).stiffness;
      const double sag = std::max(0.1 * voxel, 2 * kGravity / limit);
      EXPECT_NEAR(spring.sag(2 * kGravity), sag, 1e-9 * sag);
      EXPECT_LE(spring.stiffness(10 * voxel), limit * (1 + 1e-12));
    }
}

TEST(AutomaticSpring, TwentyTimesTheWeightSagByLessThanAThirdOfAVoxel) {
  for (const double step : {1. / 240, 1e-3})
    EXPECT_LT(automaticSpring(2, 2 * kGravity, kVoxel, step).sag(40 * kGravity), 0.31 * kVoxel);
}

// Calls check(depth) for depths up to a voxel.
template <typename Check>
void expectRises(const AutomaticSpring& spring, double tolerance, const Check& check) {
  double before = 0;
  for (double depth = 1e-3 * kVoxel; depth < kVoxel; depth += 1.01e-3 * kVoxel) {
    const double by = 1e-7 * kVoxel;
    const double slope = (spring.force(depth + by) - spring.force(depth - by)) / (2 * by);
    EXPECT_NEAR(spring.stiffness(depth), slope, tolerance * slope) << depth / kVoxel;
    EXPECT_GE(spring.stiffness(depth), before);
    EXPECT_NEAR(spring.sag(spring.force(depth)), depth, 1e-9 * kVoxel);
    check(depth);
    before = spring.stiffness(depth);
  }
}

TEST(AutomaticSpring, StiffnessIsTheForcesDerivativeAndOnlyRises) {
  for (const double step : kSteps) {
    const AutomaticSpring spring = automaticSpring(2, 2 * kGravity, kVoxel, step);
    expectRises(spring, 1e-3, [](double) {});
    EXPECT_EQ(spring.force(-kVoxel), 0);
  }
}

// A weightless mass flies in from outside, `phase` of a step before it touches, and leaves;
// `damped` scales the damping. Each row is solved as Bullet does.
double speedAfter(const AutomaticSpring& spring, double step, double speed, double phase,
                  double damped) {
  double depth = -phase * step * speed, closing = speed;
  for (int i = 0; i < 20000 && (closing > 0 || depth > 0); ++i) {
    SpringTangent tangent = spring.tangent(depth, closing, step);
    tangent.damping *= damped;
    const KelvinVoigt row = tangent.row(depth, step);
    const double inside = std::max(depth, 0.0), outside = std::min(depth, 0.0) / step;
    const double grip = step * (step * row.stiffness + row.damping);
    // impulse = step k inside + grip (v+ + outside), v+ = v - impulse / m, never pulling
    const double impulse =
        (step * row.stiffness * inside + grip * (closing + outside)) / (1 + grip / spring.mass);
    closing -= std::max(0.0, impulse) / spring.mass;
    depth += step * closing;
  }
  return -closing;
}

// Without damping the speed out is at most the speed in. With damping ratio 1 it is at most exp(-2)
// of it, as for a critically damped spring that cannot pull.
TEST(AutomaticSpring, ReturnsNoMoreThanItsDampingRatioAllows) {
  for (const double step : {1. / 60, 1. / 240, 1e-3, 1e-4})
    for (double way = 2e-3; way < 1.2; way *= 1.15)  // [voxels per step]
      for (const double phase : {0.01, 0.3, 0.5, 0.7, 0.95}) {
        const AutomaticSpring spring = automaticSpring(2, 2 * kGravity, kVoxel, step);
        const double speed = way * kVoxel / step;
        EXPECT_LE(speedAfter(spring, step, speed, phase, 0), speed) << step << ' ' << way;
        EXPECT_LE(speedAfter(spring, step, speed, phase, 1), 1.01 * std::exp(-2) * speed)
            << step << ' ' << way;
      }
}

// As long as the step allows the stiffness nothing changes; then it goes on to rise.
TEST(AutomaticSpring, WithBearsTheStepLimitsItLess) {
  for (const double step : {1. / 60, 1. / 240, 1e-3})
    for (const double joint : {0.25, 1.0}) {
      const AutomaticSpring plain = automaticSpring(2, 2 * kGravity, kVoxel, step, joint),
                            bears = automaticSpring(2, 2 * kGravity, kVoxel, step, joint, 10);
      const double limit = stepLimited(2, step).stiffness;
      expectRises(bears, 2e-3, [&](double depth) {
        EXPECT_LE(bears.stiffness(depth), 10 * limit * (1 + 1e-12));
        if (bears.stiffness(depth) < limit) {
          EXPECT_EQ(bears.force(depth), plain.force(depth));
        } else {
          EXPECT_GE(bears.force(depth), plain.force(depth));
        }
      });
    }
}

// A cube of 1 mm, voxels of a twentieth: its weight sags by a tenth of a voxel at 60 Hz, too. With
// Bullet's own solver by 5.5 voxels.
TEST(AutomaticSpring, WithBearsSmallBodiesSagAsTheyShould) {
  const double mass = 1e-6, weight = mass * kGravity, voxel = 5e-5;
  EXPECT_NEAR(automaticSpring(mass, weight, voxel, 1. / 60, 1, 100).sag(weight), 0.1 * voxel,
              1e-9 * voxel);
  EXPECT_GT(automaticSpring(mass, weight, voxel, 1. / 60).sag(weight), 5 * voxel);
}

TEST(AutomaticSpring, ReturnsNoMoreWithBears) {
  for (const double step : {1. / 60, 1. / 240, 1e-3})
    for (double way = 2e-3; way < 1.2; way *= 1.15)  // [voxels per step]
      for (const double phase : {0.01, 0.5, 0.95}) {
        const AutomaticSpring spring = automaticSpring(2, 2 * kGravity, kVoxel, step, 1, 10);
        const double speed = way * kVoxel / step;
        EXPECT_LE(speedAfter(spring, step, speed, phase, 0), speed) << step << ' ' << way;
        EXPECT_LE(speedAfter(spring, step, speed, phase, 1), 1.01 * std::exp(-2) * speed)
            << step << ' ' << way;
      }
}

// Of the mass whose weight is the force, with a solver that carries it, and of the pair's at least.
TEST(AutomaticSpring, HasDampingRatioOneForWhatItBears) {
  const double mass = 0.3, weight = mass * kGravity;
  for (const double bears : {1.0, 100.0})
    for (const double load : {0.5, 1.0, 3.0, 20.0, 1000.0}) {
      const AutomaticSpring spring = automaticSpring(mass, weight, kVoxel, 1e-3, 1, bears);
      const SpringTangent tangent = spring.tangent(spring.sag(load * weight), 0, 1e-3);
      EXPECT_NEAR(tangent.slope, spring.stiffness(spring.sag(load * weight)), 1e-9 * tangent.slope);
      const double loads = bears > 1 ? load : 1;
      const double borne = mass * std::max({1.0, loads, tangent.slope / spring.limit});
      EXPECT_NEAR(tangent.damping / (2 * std::sqrt(tangent.slope * borne)), 1, 1e-9) << load;
    }
}

// Also where rounding would make the line's zero negative: soft depth / soft is not depth.
TEST(AutomaticSpring, ARowIsNoStifferThanItsLine) {
  const AutomaticSpring spring = automaticSpring(0.7, 0.7 * kGravity, kVoxel, 1. / 240);
  for (double depth = 1e-9; depth < 2e-3; depth *= 1.1)
    for (const double closing : {-1.0, 0.0, 0.3}) {
      const SpringTangent line = spring.tangent(depth, closing, 1. / 240);
      EXPECT_GE(line.offset, 0);
      for (const double at : {depth, 1e-6 * depth, 1e-30, 1e-300, 5e-324}) {
        const KelvinVoigt row = line.row(at, 1. / 240);
        EXPECT_GE(row.stiffness, 0);
        EXPECT_LE(row.stiffness, line.slope) << depth << ' ' << at;
        EXPECT_GE(row.damping, line.damping);
        EXPECT_TRUE(std::isfinite(row.damping));
      }
    }
}

TEST(AutomaticSpring, WithoutGravityItIsAsOnTheGround) {
  EXPECT_EQ(automaticSpring(1, 0, kVoxel, 1e-3).soft, automaticSpring(1, 9.81, kVoxel, 1e-3).soft);
  EXPECT_THROW(automaticSpring(1, 9.81, 0, 1e-3), std::invalid_argument);
  EXPECT_THROW(automaticSpring(0, 9.81, kVoxel, 1e-3), std::invalid_argument);
  EXPECT_THROW(automaticSpring(1, 9.81, kVoxel, 1e-3, 0), std::invalid_argument);
  EXPECT_THROW(automaticSpring(1, 9.81, kVoxel, 1e-3, 1, 0.5), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::automatic_spring_test
