// Particles in contact with a rigid body over one step, compared with the closed form for one row,
// with a dense solution of all rows, and with the laws of friction and momentum.
#include "contact/particle_solve.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

namespace cloudcontact::particle_solve_test {
namespace {

constexpr double kStep = 1e-3;

RigidResponse freeBody(double mass, double inertia) {
  RigidResponse body;
  body.inverseMass.setConstant(1 / mass);
  body.inverseInertia = Eigen::Matrix3d::Identity() / inertia;
  return body;
}

// Particles at the lower side of a 2 kg body, each with its own normal, some with a gap.
std::vector<ParticleContact> crowd(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> real(-1, 1);
  std::vector<ParticleContact> contacts(static_cast<std::size_t>(count));
  for (ParticleContact& c : contacts) {
    c.normal = Vec3(0.3 * real(random), 0.3 * real(random), -1).normalized();
    c.arm = Vec3(0.1 * real(random), 0.1 * real(random), -0.1);
    c.inverseMass = 20 + 10 * real(random);
    c.velocity = Vec3(real(random), real(random), 1 + 0.5 * real(random));
    c.depth = 1e-3 * real(random);
    c.line.grip = 4 + 3 * real(random);
    c.line.force = c.depth > 0 ? 3e3 * c.depth : 0;
  }
  return contacts;
}

TEST(ParticleSolve, OneOnAFixedBodyIsABackwardEulerStep) {
  for (const double depth : {2e-3, -2e-4}) {
    std::vector<ParticleContact> one(1);
    RigidResponse wall;
    one[0].inverseMass = 50;
    one[0].velocity = {0, 0, -0.5};
    one[0].depth = depth;
    const double k = 700, c = 3;
    one[0].line = {k * std::max(0.0, depth), kStep * k + c};
    solveParticles(one, wall, 0, kStep);
    // m (v+ - v) = h (k d+ - c v+) with the depth at the end of the step, d+ = d - h v+.
    const double m = 1 / 50., late = std::max(0.0, -depth);
    const double inside = k * std::max(0.0, depth) - (k + c / kStep) * late;
    const double v = (-0.5 * m + kStep * inside) / (m + kStep * (kStep * k + c));
    EXPECT_NEAR(one[0].velocity.z(), v, 1e-12);
    EXPECT_NEAR(one[0].push, m * (v + 0.5), 1e-12);
    EXPECT_EQ(wall.linear, Vec3::Zero());
  }
}

TEST(ParticleSolve, ManyOnAFreeBodySolveOneLinearSystem) {
  std::vector<ParticleContact> contacts = crowd(40, 3), before = contacts;
  RigidResponse body = freeBody(2, 0.02);
  solveParticles(contacts, body, 0, kStep);
  // Active rows: push / h = force + grip (rate - late), where the rate depends on all pushes.
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (contacts[i].push > 0) rows.push_back(i);
  ASSERT_GT(rows.size(), 10u);
  ASSERT_LT(rows.size(), contacts.size()) << "none separated";
  const Eigen::Index n = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd right(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ParticleContact& a = before[rows[static_cast<std::size_t>(i)]];
    const double late = std::max(0.0, -a.depth) / kStep;
    right[i] = kStep * (a.line.force + a.line.grip * (-a.velocity.dot(a.normal) - late));
    matrix(i, i) += 1 + kStep * a.line.grip * a.inverseMass;
    for (Eigen::Index j = 0; j < n; ++j) {
      const ParticleContact& b = before[rows[static_cast<std::size_t>(j)]];
      const double both =
          a.normal.dot(b.normal) / 2 + a.arm.cross(a.normal).dot(b.arm.cross(b.normal)) / 0.02;
      matrix(i, j) += kStep * a.line.grip * both;
    }
  }
  const Eigen::VectorXd push = matrix.partialPivLu().solve(right);
  for (Eigen::Index i = 0; i < n; ++i)
    EXPECT_NEAR(contacts[rows[static_cast<std::size_t>(i)]].push, push[i],
                1e-7 * push.cwiseAbs().maxCoeff());
}

TEST(ParticleSolve, ConservesLinearAndAngularMomentum) {
  std::vector<ParticleContact> contacts = crowd(30, 5);
  const std::vector<ParticleContact> before = contacts;
  RigidResponse body = freeBody(0.5, 0.004);
  solveParticles(contacts, body, 0.4, kStep);
  Vec3 linear = 0.5 * body.linear, angular = 0.004 * body.angular, all = Vec3::Zero();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Vec3 gained = (contacts[i].velocity - before[i].velocity) / before[i].inverseMass;
    EXPECT_LT((gained - contacts[i].impulse()).norm(), 1e-12);
    linear += gained;
    angular += contacts[i].arm.cross(gained);
    all += gained;
  }
  EXPECT_LT(linear.norm(), 1e-12);
  EXPECT_LT(angular.norm(), 1e-12);
  EXPECT_GT(all.norm(), 0.01);
}

TEST(ParticleSolve, FrictionStopsASlipOrReachesItsLimit) {
  std::vector<ParticleContact> contacts = crowd(60, 7);
  for (std::size_t i = 0; i < 30; ++i) {  // half of them approach almost along the normal
    ParticleContact& c = contacts[i];
    c.velocity = -c.normal + 0.02 * Vec3::Ones();
  }
  RigidResponse body = freeBody(20, 0.2);
  solveParticles(contacts, body, 0.5, kStep);
  int stuck = 0, slid = 0;
  for (const ParticleContact& c : contacts) {
    EXPECT_NEAR(c.rub.dot(c.normal), 0, 1e-12);
    if (!(c.push > 0)) {
      EXPECT_EQ(c.rub.norm(), 0);
      continue;
    }
    const Vec3 meeting = c.velocity - body.at(c.arm);
    const Vec3 slip = meeting - meeting.dot(c.normal) * c.normal;
    EXPECT_LE(c.rub.norm(), 0.5 * c.push * (1 + 1e-9));
    if (c.rub.norm() > 0.499999 * c.push) {
      ++slid;
      EXPECT_LT(c.rub.normalized().dot(slip.normalized()), -0.99);
    } else {
      ++stuck;
      EXPECT_LT(slip.norm(), 1e-6);
    }
  }
  EXPECT_GT(slid, 3);
  EXPECT_GT(stuck, 0);
}

}  // namespace
}  // namespace cloudcontact::particle_solve_test
