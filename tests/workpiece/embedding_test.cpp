// Embedding depth: all searches find the same depth for every law, and report when there is none.
#include <gtest/gtest.h>

#include <cloudcontact/workpiece/embedding.h>

#include <cmath>
#include <limits>

namespace cloudcontact::embedding_test {
namespace {

constexpr HandSpring kHand{800, 2e-3};
constexpr double kStep = 1e-3;

EmbeddingSettings by(Search search) {
  EmbeddingSettings s;
  s.search = search;
  return s;
}

struct Case {
  const char* name;
  Law law;
  LawState before;
  double truth;  // in closed form [m]
};

// Hertz: F = a d^1.5.
double hertz(double depth) {
  return 3e5 * depth * std::sqrt(depth);
}

std::vector<Case> cases() {
  const double k = 2e4, c = 3, reach = kHand.reach, hand = kHand.stiffness, h = kStep;
  // (k + c/h) d - c/h d0 = hand (reach - d)
  const double d0 = 5e-5;
  const double voigt = (hand * reach + c / h * d0) / (k + c / h + hand);
  // Maxwell: F+ = (F + k (d - d0)) / (1 + h k / c)
  const double f0 = 0.4, slow = 1 + h * k / c;
  const double maxwell = (hand * reach - (f0 - k * d0) / slow) / (k / slow + hand);
  const double k1 = 1e4, c1 = 8, slow1 = 1 + h * k1 / c1;
  const double solid = (hand * reach - (f0 - k1 * d0) / slow1) / (k + k1 / slow1 + hand);
  // A table of two lines, 1000 N/m up to 0.1 mm, then 30,000.
  const double table = (hand * reach + 29000 * 1e-4) / (30000 + hand);
  return {{"Kelvin-Voigt", KelvinVoigt{k, c}, {d0, 0}, voigt},
          {"Maxwell", Maxwell{k, c}, {d0, f0}, maxwell},
          {"standard linear solid", StandardLinearSolid{k, k1, c1}, {d0, f0}, solid},
          {"table", TableLaw{{{{1e-4, 0.1}, {2e-4, 3.1}}}, 0}, {}, table},
          {"user", UserLaw{[](double d, double) { return hertz(d); }}, {}, 0}};
}

TEST(Embedding, AllSearchesAgreeOnEveryLaw) {
  for (const Case& c : cases()) {
    const Embedding bisected = embed(c.law, c.before, kStep, kHand, by(Search::Bisection));
    const Embedding newton = embed(c.law, c.before, kStep, kHand, by(Search::Newton));
    const Embedding looked = embed(c.law, c.before, kStep, kHand, by(Search::Table));
    for (const Embedding& e : {bisected, newton, looked}) {
      EXPECT_EQ(e.end, EmbeddingEnd::Found) << c.name;
      EXPECT_NEAR(e.depth, bisected.depth, 1e-6 * kHand.reach) << c.name;
      if (c.truth > 0) {
        EXPECT_NEAR(e.depth, c.truth, 1e-6 * kHand.reach) << c.name;
      } else {
        EXPECT_NEAR(hertz(e.depth), kHand.stiffness * (kHand.reach - e.depth), 1e-4) << c.name;
      }
      EXPECT_NEAR(e.force, kHand.stiffness * (kHand.reach - e.depth), 1e-3) << c.name;
      EXPECT_GT(e.iterations, 0);
    }
    EXPECT_GE(bisected.iterations, 20) << "a bit a step";
    EXPECT_LE(newton.iterations, 14) << c.name;
    RecordProperty(c.name, newton.iterations);
  }
}

// The slope of each law is that of its force, and Newton's method uses it.
TEST(Embedding, NewtonFollowsTheSlope) {
  for (const Case& c : cases())
    for (const double d : {0.7e-4, 1.7e-4, 9e-4}) {
      const double h = 1e-9;
      const double slope =
          (lawForce(c.law, c.before, d + h, kStep) - lawForce(c.law, c.before, d - h, kStep)) /
          (2 * h);
      EXPECT_NEAR(lawSlope(c.law, c.before, d, kStep), slope, 1e-4 * slope) << c.name;
    }
  EXPECT_EQ(lawSlope(KelvinVoigt{1e4, 1}, {}, -1, kStep), 0);
  int slopes = 0;
  const Index steep([](double d) { return 1e-3 * std::expm1(6e3 * d); },
                    [&](double d) {
                      ++slopes;
                      return 6 * std::exp(6e3 * d);
                    });
  const Embedding newton = embed(steep, kHand, by(Search::Newton));
  const Embedding secants = embed(Index(steep.force), kHand, by(Search::Newton));
  EXPECT_GT(slopes, 0);
  EXPECT_LE(newton.iterations, 13);
  EXPECT_NEAR(newton.depth, secants.depth, 1e-6 * kHand.reach);
  // A slope that is wrong or no number costs steps, not the answer.
  for (const double wrong : {0.0, 1e12, -3e3, std::numeric_limits<double>::quiet_NaN()}) {
    const Index misled(steep.force, [=](double) { return wrong; });
    EXPECT_NEAR(embed(misled, kHand, by(Search::Newton)).depth, secants.depth, 1e-6 * kHand.reach);
  }
}

// Only evaluations of the index count, and all of them.
TEST(Embedding, TableCountsTrueEvaluations) {
  int calls = 0;
  const Index index([&](double d) {
    ++calls;
    return hertz(d);
  });
  const Embedding whole = embed(index, kHand, by(Search::Table));
  EXPECT_EQ(whole.iterations, calls);
  EXPECT_GE(whole.iterations, 64);
  EmbeddingTable table(index, kHand.reach, 64);
  calls = 0;
  EXPECT_EQ(table.find(kHand).iterations, 0);
  EXPECT_EQ(calls, 0);
  EXPECT_EQ(table.find(kHand, {}, index).iterations, calls);
  EXPECT_THROW(EmbeddingTable().find(kHand), std::logic_error);
}

TEST(Embedding, ScaleDoesNotMatter) {
  for (const double scale : {1e-6, 1.0, 1e3}) {
    const Index index = [&](double d) { return 5 * std::sqrt(d / scale); };
    const Embedding e = embed(index, {10 / scale, scale}, by(Search::Newton));
    // 5 sqrt(x) = 10 (1 - x): sqrt(x) = (sqrt(17) - 1) / 4.
    const double root = (std::sqrt(17.0) - 1) / 4;
    EXPECT_NEAR(e.depth / scale, root * root, 1e-6);
  }
}

TEST(Embedding, SaysWhenThereIsNoAnswer) {
  const Index soft = [](double) { return 0.0; };
  const Index hard = [](double d) { return 5 + 1e4 * d; };
  const Index broken = [](double d) {
    return d > 1e-3 ? std::numeric_limits<double>::quiet_NaN() : 0.0;
  };
  for (const Search s : {Search::Bisection, Search::Newton, Search::Table}) {
    EXPECT_EQ(embed(soft, kHand, by(s)).end, EmbeddingEnd::TooSoft);
    EXPECT_EQ(embed(soft, kHand, by(s)).depth, kHand.reach) << "where the hand is";
    EXPECT_EQ(embed(hard, kHand, by(s)).end, EmbeddingEnd::NotPressed);
    EXPECT_EQ(embed(hard, kHand, by(s)).depth, 0) << "the material outdoes the hand at once";
    EXPECT_EQ(embed(hard, {800, -1}, by(s)).end, EmbeddingEnd::NotPressed);
    EXPECT_EQ(embed(broken, kHand, by(s)).end, EmbeddingEnd::NoNumber);
  }
  EmbeddingSettings few = by(Search::Bisection);
  few.iterations = 6;
  const Embedding e = embed([](double d) { return 2e4 * d; }, kHand, few);
  EXPECT_EQ(e.end, EmbeddingEnd::NotConverged);
  EXPECT_NEAR(e.depth, kHand.reach * 800 / 20800, kHand.reach / 16) << "but near";
  EXPECT_THROW(embed(soft, {-1, 1}, {}), std::invalid_argument);
  EXPECT_THROW(embed(soft, {1, std::numeric_limits<double>::infinity()}, {}),
               std::invalid_argument);
  EXPECT_THROW(EmbeddingTable(soft, 0, 10), std::invalid_argument);
}

// A step, a kink and a flat part of the index: the bracket closes anyway.
TEST(Embedding, IndicesThatDefyNewton) {
  const Index step = [](double d) { return d < 7.3e-4 ? 0.0 : 100.0; };
  const Index flat = [](double d) { return d < 1.9e-3 ? 1e-9 * d : 1e9 * (d - 1.9e-3); };
  for (const Search s : {Search::Bisection, Search::Newton, Search::Table}) {
    EXPECT_NEAR(embed(step, kHand, by(s)).depth, 7.3e-4, 1e-6 * kHand.reach);
    EXPECT_NEAR(embed(flat, kHand, by(s)).depth, 1.9e-3, 1e-6 * kHand.reach);
    EXPECT_LE(embed(step, kHand, by(s)).iterations, s == Search::Table ? 128 : 64);
  }
}

// A table of a law, searched after the law has changed.
TEST(Embedding, TableOfAnotherStateIsMendedByTheLawItself) {
  const Law law = StandardLinearSolid{2e4, 1e4, 8};
  LawState state{2e-4, 1.5};
  const EmbeddingTable table([&](double d) { return lawForce(law, {}, d, kStep); }, kHand.reach,
                             32);
  const Index now = [&](double d) { return lawForce(law, state, d, kStep); };
  EXPECT_NEAR(table.find(kHand, {}, now).depth, embed(law, state, kStep, kHand).depth,
              1e-6 * kHand.reach);
  EXPECT_NEAR(table.at(1e-3), lawForce(law, {}, 1e-3, kStep), 1e-9);
}

}  // namespace
}  // namespace cloudcontact::embedding_test
