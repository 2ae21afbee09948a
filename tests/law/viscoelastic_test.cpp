// Each law against closed forms (relaxation, creep, a damped oscillation, the energy of a cycle),
// its limits and the order of its steps; nonlinear laws gain no energy.
#include <cloudcontact/law/law.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>

namespace cloudcontact::viscoelastic_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr StandardLinearSolid kSolid{300, 700, 14};  // branch time 0.02 s, creep time 0.0667 s
constexpr Maxwell kMaxwell{900, 18};                 // 0.02 s

// The depth at which the law carries `load` at the step's end, by one Newton step.
double depthUnder(const Law& law, const LawState& state, double load, double step) {
  const LawTangent line = lawTangent(law, state, 0, step);
  return state.depth + step * (load - line.force) / line.grip;
}

// The force at time `end` at constant `depth`.
double relaxed(const Law& law, double depth, double end, int steps) {
  LawState state;
  double force = 0;
  for (int i = 0; i < steps; ++i) {
    force = lawForce(law, state, depth, end / steps);
    state = lawAdvance(law, state, depth, end / steps);
  }
  return force;
}

// The depth at time `end` under constant load.
double crept(const Law& law, double load, double end, int steps) {
  LawState state;
  for (int i = 0; i < steps; ++i)
    state = lawAdvance(law, state, depthUnder(law, state, load, end / steps), end / steps);
  return state.depth;
}

// The error of `run(steps)` against `truth` is proportional to the step, and small for many steps.
template <class Run>
void expectFirstOrder(const Run& run, double truth) {
  const double coarse = run(200) - truth, fine = run(400) - truth, finest = run(4000) - truth;
  EXPECT_NEAR(coarse / fine, 2, 0.1);
  EXPECT_NEAR(coarse / finest, 20, 1.5);
  EXPECT_LT(std::abs(finest), 1e-3 * std::abs(truth));
  EXPECT_GT(std::abs(coarse), 1e-12 * std::abs(truth)) << "nothing was refined";
}

TEST(Viscoelastic, AHeldDepthRelaxesByEachLaw) {
  const double depth = 2e-3, end = 0.03;
  expectFirstOrder([&](int n) { return relaxed(kMaxwell, depth, end, n); },
                   900 * depth * std::exp(-end / 0.02));
  expectFirstOrder([&](int n) { return relaxed(kSolid, depth, end, n); },
                   depth * (300 + 700 * std::exp(-end / 0.02)));
  EXPECT_NEAR(relaxed(KelvinVoigt{300, 7}, depth, end, 3), 300 * depth, 1e-12);
}

TEST(Viscoelastic, AHeldForceCreepsByEachLaw) {
  const double load = 0.7, end = 0.05;
  expectFirstOrder(
      [&](int n) {
        return crept(KelvinVoigt{300, 9}, load, end, n);
      },
      load / 300 * (1 - std::exp(-300 * end / 9)));
  const double creepTime = 14. / 700 * 1000 / 300;
  expectFirstOrder([&](int n) { return crept(kSolid, load, end, n); },
                   load / 300 * (1 - 0.7 * std::exp(-end / creepTime)));
  // Maxwell's creep is a straight line, on which backward Euler is exact.
  for (const int steps : {1, 7, 100})
    EXPECT_NEAR(crept(kMaxwell, load, end, steps), load / 900 + load * end / 18, 1e-12);
}

// A mass on Kelvin-Voigt under its weight, released at depth 0. It never leaves, so the closed form
// holds throughout.
TEST(Viscoelastic, AMassOnKelvinVoigtSwingsAsADampedOscillator) {
  const double mass = 0.5, k = 800, c = 10, weight = mass * 9.81, end = 0.3;
  const double decay = c / (2 * mass), swing = std::sqrt(k / mass - decay * decay);
  const double rest = weight / k;
  const double truth = rest - rest * std::exp(-decay * end) *
                                  (std::cos(swing * end) + decay / swing * std::sin(swing * end));
  const auto run = [&](int steps) {
    const double h = end / steps;
    LawState state;
    double rate = 0;
    for (int i = 0; i < steps; ++i) {
      const LawTangent line = lawTangent(KelvinVoigt{k, c}, state, rate, h);
      rate = (mass * rate + h * (weight - line.force)) / (mass + h * line.grip);
      state = lawAdvance(KelvinVoigt{k, c}, state, state.depth + h * rate, h);
    }
    return state.depth;
  };
  const double coarse = run(20000) - truth, fine = run(40000) - truth;
  EXPECT_NEAR(coarse / fine, 2, 0.02);
  EXPECT_LT(std::abs(fine), 1e-3 * rest);
}

// Over a cycle d = d0 + a sin wt a standard linear solid loses pi a^2 k1 w tau / (1 + (w tau)^2).
TEST(Viscoelastic, ACycleLosesEnergyByTheLossModulus) {
  const double middle = 5e-3, a = 1e-3, tau = 0.02;
  for (const double turns : {0.2, 1.0, 5.0}) {  // w tau
    const double w = turns / tau, truth = kPi * a * a * 700 * turns / (1 + turns * turns);
    const auto run = [&](int steps) {
      const double h = 2 * kPi / w / steps;
      LawState state;
      double lost = 0;
      const int settle = static_cast<int>(std::ceil(20 * w * tau / (2 * kPi)) + 1) * steps;
      for (int i = 1; i <= settle + steps; ++i) {
        const double depth = middle + a * std::sin(w * h * i);
        const double force = lawForce(kSolid, state, depth, h);
        if (i > settle) lost += force * (depth - state.depth);
        state = lawAdvance(kSolid, state, depth, h);
      }
      return lost;
    };
    const double coarse = run(500) - truth, fine = run(1000) - truth;
    EXPECT_LT(std::abs(fine), 0.03 * truth) << turns;
    EXPECT_NEAR(coarse / fine, 2, 0.1) << turns;
  }
}

TEST(Viscoelastic, TheSolidsLimitsAreSprings) {
  LawState slow, none;
  StandardLinearSolid stiff = kSolid, soft = kSolid;
  stiff.branchDamping = 1e12;
  soft.branchDamping = 1e-12;
  double depth = 0;
  for (int i = 1; i < 60; ++i) {
    const double next = 4e-3 * std::sin(0.05 * i);
    EXPECT_NEAR(lawForce(stiff, slow, next, 1e-3), 1000 * next, 1e-8);
    EXPECT_NEAR(lawForce(soft, none, next, 1e-3), 300 * next, 1e-8);
    slow = lawAdvance(stiff, slow, next, 1e-3);
    none = lawAdvance(soft, none, next, 1e-3);
    depth = std::max(depth, next);
  }
  EXPECT_GT(depth, 3.9e-3);
  soft.branchDamping = 0;
  EXPECT_EQ(lawForce(soft, {1e-3, 0}, 2e-3, 1e-3), 300 * 2e-3);
}

TEST(Viscoelastic, TheLineIsTheLawWhereTheLawIsLinear) {
  const TableLaw line{{{1e-3, 0.3}, {2e-3, 0.6}}, 2};
  const UserLaw user{[](double d, double v) { return 300 * d + 2 * v; }};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> real(0, 1);
  int pushing = 0;
  for (int i = 0; i < 2000; ++i) {
    const double depth = 3e-3 * real(random), step = std::pow(10, -4 + 2 * real(random));
    const double rate = (2 * real(random) - 1) * depth / step;
    for (const Law& law :
         {Law(KelvinVoigt{300, 2}), Law(kMaxwell), Law(kSolid), Law(line), Law(user)}) {
      const bool branch = law.index() == 1 || law.index() == 2;
      const LawState state{depth, branch ? 0.5 * real(random) : 0};
      const LawTangent tangent = lawTangent(law, state, 0.1 * (real(random) - 0.5), step);
      const double force = lawForce(law, state, depth + step * rate, step);
      EXPECT_NEAR(force, std::max(0.0, tangent.force + tangent.grip * rate), 1e-9) << law.index();
      pushing += force > 0;
    }
  }
  EXPECT_GT(pushing, 4000);
}

TEST(Viscoelastic, NeverPullsAndNeverPushesApart) {
  for (const Law& law :
       {Law(KelvinVoigt{300, 20}), Law(kMaxwell), Law(kSolid), Law(TableLaw{{{1e-3, 2}}, 30}),
        Law(UserLaw{[](double d, double v) { return 50 * d + 20 * v; }})}) {
    LawState deep;
    for (int i = 0; i < 500; ++i) deep = lawAdvance(law, deep, 2e-3, 1e-3);
    EXPECT_EQ(lawForce(law, deep, 1e-4, 1e-3), 0) << law.index();
    EXPECT_EQ(lawForce(law, deep, 0, 1e-3), 0);
    EXPECT_EQ(lawForce(law, deep, -1e-3, 1e-3), 0);
    // Parted bodies have no state.
    const LawState apart = lawAdvance(law, deep, -1e-3, 1e-3);
    EXPECT_EQ(apart.depth, 0);
    EXPECT_EQ(apart.branchForce, 0);
    EXPECT_GT(lawForce(law, apart, 1e-4, 1e-3), 0);
  }
}

// Pulled back in one step, the branch balances the spring. Held there, it relaxes and the spring
// pushes again.
TEST(Viscoelastic, ABranchNeverPulls) {
  LawState state{2e-3, 0};
  state = lawAdvance(kSolid, state, 1e-3, 1e-9);
  EXPECT_NEAR(state.branchForce, -0.3, 1e-9);
  for (int i = 0; i < 1000; ++i) state = lawAdvance(kSolid, state, 1e-3, 1e-3);
  EXPECT_NEAR(lawForce(kSolid, state, 1e-3, 1e-3), 0.3, 1e-9);
}

TEST(Viscoelastic, ATableIsItsPointsWithLinesBetween) {
  const TableLaw law{{{1e-3, 1}, {2e-3, 5}, {4e-3, 6}}, 0};
  const auto force = [&law](double depth) { return lawForce(law, {depth, 0}, depth, 1e-3); };
  EXPECT_NEAR(force(0.5e-3), 0.5, 1e-12);  // from {0, 0}
  EXPECT_NEAR(force(1e-3), 1, 1e-12);
  EXPECT_NEAR(force(1.25e-3), 2, 1e-12);
  EXPECT_NEAR(force(4e-3), 6, 1e-12);
  EXPECT_NEAR(force(8e-3), 8, 1e-12);  // the last segment continues
  const TableLaw ready{{{0, 2}, {1e-3, 3}}, 0};
  EXPECT_NEAR(lawForce(ready, {1e-6, 0}, 1e-6, 1e-3), 2.001, 1e-9);
  EXPECT_EQ(lawForce(ready, {}, 0, 1e-3), 0);
  const TableLaw yields{{{1e-3, 3}, {2e-3, 1}}, 0};
  EXPECT_EQ(lawForce(yields, {5e-3, 0}, 5e-3, 1e-3), 0);
}

// The speed of a mass after a bounce, stepped as a solver steps it.
double speedAfter(const Law& law, double mass, double speed, double step, double phase) {
  LawState state;
  double gap = phase * step * speed, rate = speed;
  for (int i = 0; i < 100000 && (rate > 0 || state.depth > 0); ++i) {
    const LawTangent line = lawTangent(law, state, rate, step);
    const double late = gap / step;  // the part inside of a step that begins outside
    const double push = (line.force + line.grip * (rate - late)) / (1 + step * line.grip / mass);
    rate -= step * std::max(0.0, push) / mass;
    const double depth = (state.depth > 0 ? state.depth : -gap) + step * rate;
    gap = std::max(0.0, -depth);
    state = lawAdvance(law, state, depth, step);
  }
  return -rate;
}

TEST(Viscoelastic, NoLawReturnsMoreThanItTook) {
  const auto power = [](double exponent) {
    return UserLaw{[exponent](double d, double) { return 10 * std::pow(d / 1e-3, exponent); }};
  };
  const Law laws[] = {KelvinVoigt{5000, 0},
                      kMaxwell,
                      kSolid,
                      TableLaw{{{1e-3, 1}, {2e-3, 10}, {3e-3, 50}}, 0},   // stiffens
                      TableLaw{{{1e-3, 10}, {2e-3, 13}, {9e-3, 14}}, 0},  // yields
                      power(1.5),
                      power(0.5),
                      power(3)};
  for (const Law& law : laws)
    for (const double step : {1. / 60, 1. / 240, 1e-3, 1e-5})
      for (const double phase : {0.01, 0.4, 0.9})
        for (const double speed : {1e-3, 0.05, 0.7}) {
          const double left = speedAfter(law, 0.1, speed, step, phase);
          EXPECT_LE(left, speed * (1 + 1e-9)) << law.index() << ' ' << step << ' ' << speed;
          EXPECT_GE(left, -1e-12);
        }
  // Without damping a fine step returns nearly all.
  for (const std::size_t i : {0, 3, 5})
    EXPECT_GT(speedAfter(laws[i], 0.1, 0.05, 1e-6, 0.5), 0.049) << i;
}

// The same law for a body a thousand times smaller: lengths scale with s, forces with s^3.
TEST(Viscoelastic, ScaleDoesNotMatter) {
  const double s = 1e-3;
  const StandardLinearSolid tiny{300 * s * s, 700 * s * s, 14 * s * s};
  LawState big, small;
  for (int i = 1; i < 50; ++i) {
    const double depth = 4e-3 * std::sin(0.07 * i);
    const double force = lawForce(kSolid, big, depth, 1e-3);
    EXPECT_NEAR(lawForce(tiny, small, s * depth, 1e-3), s * s * s * force, 1e-12 * s * s * s);
    big = lawAdvance(kSolid, big, depth, 1e-3);
    small = lawAdvance(tiny, small, s * depth, 1e-3);
  }
}

std::string refusal(const Law& law) {
  try {
    validate(law);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Viscoelastic, RefusesInvalidLawsByField) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = 1 / std::sin(0.0);
  const auto names = [](const Law& law, const char* field) {
    EXPECT_NE(refusal(law).find(field), std::string::npos) << '"' << refusal(law) << '"';
  };
  for (const double bad : {-1.0, nan, inf}) {
    names(KelvinVoigt{bad, 1}, "KelvinVoigt::stiffness");
    names(KelvinVoigt{1, bad}, "KelvinVoigt::damping");
    names(Maxwell{bad, 1}, "Maxwell::stiffness");
    names(Maxwell{1, bad}, "Maxwell::damping");
    names(StandardLinearSolid{bad, 1, 1}, "StandardLinearSolid::stiffness");
    names(StandardLinearSolid{1, bad, 1}, "StandardLinearSolid::branchStiffness");
    names(StandardLinearSolid{1, 1, bad}, "StandardLinearSolid::branchDamping");
    names(TableLaw{{{1, 1}}, bad}, "TableLaw::damping");
    names(TableLaw{{{bad, 1}}, 0}, "TableLaw::depthForce");
    names(TableLaw{{{1, bad}}, 0}, "TableLaw::depthForce");
  }
  names(KelvinVoigt{}, "KelvinVoigt::stiffness");
  names(Maxwell{1, 0}, "Maxwell::damping");
  names(UserLaw{}, "UserLaw::force");
  names(TableLaw{}, "TableLaw::depthForce");
  names(TableLaw{{{0, 1}}, 0}, "TableLaw::depthForce");
  names(TableLaw{{{2, 1}, {1, 2}}, 0}, "TableLaw::depthForce");
  names(TableLaw{{{1, 1}, {1, 2}}, 0}, "TableLaw::depthForce");
  EXPECT_EQ(refusal(kSolid), "");
  EXPECT_EQ(refusal(TableLaw{{{0, 1}, {1, 2}}, 0}), "");
  EXPECT_EQ(refusal(KelvinVoigt{0, 1}), "");
}

TEST(Viscoelastic, RefusesStepsThatAreNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(lawForce(kSolid, {}, nan, 1e-3), std::invalid_argument);
  EXPECT_THROW(lawForce(kSolid, {}, 1e-3, 0), std::invalid_argument);
  EXPECT_THROW(lawForce(kSolid, {nan, 0}, 1e-3, 1e-3), std::invalid_argument);
  EXPECT_THROW(lawAdvance(kSolid, {0, nan}, 1e-3, 1e-3), std::invalid_argument);
  EXPECT_THROW(lawTangent(kSolid, {}, nan, 1e-3), std::invalid_argument);
  const UserLaw wild{[nan](double, double) { return nan; }};
  EXPECT_THROW(lawForce(wild, {}, 1e-3, 1e-3), std::runtime_error);
  EXPECT_THROW(lawTangent(wild, {1e-3, 0}, 0, 1e-3), std::runtime_error);
}

}  // namespace
}  // namespace cloudcontact::viscoelastic_test
