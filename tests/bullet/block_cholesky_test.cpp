// BlockCholesky against a dense factor, on chains, stars, heaps and rings of bodies.
#include "bullet/block_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <random>
#include <vector>

namespace cloudcontact::testing::block_cholesky_test {
namespace {

using Pairs = std::vector<BlockCholesky::Pair>;
constexpr int kSize = BlockCholesky::kSize;

Pairs chain(int bodies) {
  Pairs pairs;
  for (int i = 0; i + 1 < bodies; ++i) pairs.push_back({i, i + 1});
  return pairs;
}

// The first body in the middle, so that eliminating it first would fill everything.
Pairs star(int bodies) {
  Pairs pairs;
  for (int i = 1; i < bodies; ++i) pairs.push_back({0, i});
  return pairs;
}

Pairs ring(int bodies) {
  Pairs pairs = chain(bodies);
  pairs.push_back({0, bodies - 1});
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

Pairs heap(int bodies, std::mt19937& random) {
  Pairs pairs;
  for (int i = 0; i < bodies; ++i)
    for (int j = i + 1; j < bodies; ++j)
      if (random() % 4 == 0) pairs.push_back({i, j});
  return pairs;
}

// Unit matrix plus w g g^T of one row of numbers g a pair, in both.
Eigen::MatrixXd fill(BlockCholesky& matrix, int bodies, const Pairs& pairs, double stiffest,
                     std::mt19937& random) {
  std::uniform_real_distribution<double> number(-1, 1);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Identity(kSize * bodies, kSize * bodies);
  matrix.reset(bodies, pairs);
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const auto [a, b] = pairs[p];
    Eigen::VectorXd row = Eigen::VectorXd::Zero(kSize * bodies);
    for (int k = 0; k < kSize; ++k) {
      row[kSize * a + k] = number(random);
      row[kSize * b + k] = number(random);
    }
    const Eigen::MatrixXd add =
        std::pow(stiffest, std::abs(number(random))) * row * row.transpose();
    dense += add;
    const auto put = [&](BlockCholesky::Block& block, int rows, int columns) {
      for (int j = 0; j < kSize; ++j)
        for (int i = 0; i < kSize; ++i)
          block[std::size_t(kSize * j + i)] += add(kSize * rows + i, kSize * columns + j);
    };
    put(matrix.diagonal(a), a, a);
    put(matrix.diagonal(b), b, b);
    const auto [block, swapped] = matrix.beside(p);
    swapped ? put(block, b, a) : put(block, a, b);
  }
  return dense;
}

TEST(BlockCholesky, SolvesAsADenseFactorDoes) {
  std::mt19937 random(1);
  BlockCholesky matrix;  // one for all, as a solver has it
  for (const Pairs& pairs :
       {Pairs{}, chain(2), chain(9), star(9), ring(9), heap(9, random), heap(9, random)}) {
    const int bodies = 9;
    const Eigen::MatrixXd dense = fill(matrix, bodies, pairs, 1e6, random);
    ASSERT_TRUE(matrix.factor());
    const Eigen::VectorXd right = Eigen::VectorXd::Random(kSize * bodies);
    Eigen::VectorXd x = right;
    matrix.solve(x.data());
    EXPECT_LT((x - dense.llt().solve(right)).norm(), 1e-8 * right.norm()) << pairs.size();
    EXPECT_LT((dense * x - right).norm(), 1e-8 * right.norm()) << pairs.size();
  }
}

// factor() keeps the matrix: what is added later counts, and what is taken away no more.
TEST(BlockCholesky, ChangesAndFactorsAgain) {
  std::mt19937 random(2);
  BlockCholesky matrix;
  Eigen::MatrixXd dense = fill(matrix, 3, ring(3), 10, random);
  ASSERT_TRUE(matrix.factor());
  for (const double by : {5.0, -5.0}) {
    for (std::size_t k = 0; k < kSize; ++k) matrix.diagonal(1)[kSize * k + k] += by;
    dense.block<kSize, kSize>(kSize, kSize).diagonal().array() += by;
    ASSERT_TRUE(matrix.factor());
    Eigen::VectorXd x = Eigen::VectorXd::Ones(3 * kSize);
    matrix.solve(x.data());
    EXPECT_LT((dense * x - Eigen::VectorXd::Ones(3 * kSize)).norm(), 1e-10);
  }
}

TEST(BlockCholesky, RefusesWhatIsNotPositiveDefinite) {
  BlockCholesky matrix;
  matrix.reset(2, {{0, 1}});
  matrix.diagonal(1)[0] = -1;
  EXPECT_FALSE(matrix.factor());
}

}  // namespace
}  // namespace cloudcontact::testing::block_cholesky_test
