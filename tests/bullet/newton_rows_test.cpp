// NewtonRows against what any impulses of contacts with friction must be: pushes that part what
// closes, friction within Coulomb's law and against the slip, and no energy from nowhere.
#include "bullet/newton_rows.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

namespace cloudcontact::testing::newton_rows_test {
namespace {

constexpr double kSpeed = 1e-5;  // [m/s] by how much rows may miss
constexpr double kSoft = 1e-3;   // [1/kg] of rows

// Balls of a kilogram that move at random and touch at random places, as in a heap that is hit.
// Where each has many contacts, of any direction, friction presses what it holds.
struct Jam {
  Jam(unsigned seed, int balls, int touches, double friction) : random(seed) {
    bodies.push_back({});
    bodies[0].m_originalBody = nullptr;
    for (int i = 0; i < balls; ++i) {
      rigid.push_back(std::make_unique<btRigidBody>(1, nullptr, &shape, btVector3(0.1, 0.1, 0.1)));
      rigid.back()->updateInertiaTensor();
      btSolverBody body;
      body.m_originalBody = rigid.back().get();
      body.internalSetInvMass(btVector3(1, 1, 1));
      bodies.push_back(body);
      speeds.push_back({vector(), vector()});
    }
    for (int i = 0; i < touches; ++i) addContact(friction);
  }

  btVector3 vector() {
    return {btScalar(any(random)), btScalar(any(random)), btScalar(any(random))};
  }

  void addContact(double friction) {
    std::uniform_int_distribution<int> which(0, bodies.size() - 1);
    const int a = which(random);
    int b = which(random);
    while (b == a) b = which(random);
    const btVector3 normal = vector().normalized(), armA = vector() * 0.3, armB = vector() * 0.3;
    btVector3 side[2];
    btPlaneSpace1(normal, side[0], side[1]);
    contacts.push_back(row(a, b, armA, armB, normal));
    contacts[contacts.size() - 1].m_upperLimit = 1e10f;
    for (const btVector3& along : side) {
      frictions.push_back(row(a, b, armA, armB, along));
      frictions[frictions.size() - 1].m_friction = static_cast<btScalar>(friction);
      frictions[frictions.size() - 1].m_frictionIndex = contacts.size() - 1;
    }
  }

  btSolverConstraint row(int a, int b, const btVector3& armA, const btVector3& armB,
                         const btVector3& along) {
    btSolverConstraint made = {};
    made.m_solverBodyIdA = a, made.m_solverBodyIdB = b;
    made.m_contactNormal1 = along, made.m_contactNormal2 = -along;
    made.m_relpos1CrossNormal = armA.cross(along), made.m_relpos2CrossNormal = -armB.cross(along);
    made.m_jacDiagABInv = 1, made.m_cfm = kSoft;
    made.m_rhs = static_cast<btScalar>(-speedOf(made, speeds));
    return made;
  }

  struct Velocity {
    btVector3 linear, angular;
  };
  // Of a row's places from each other [m/s].
  double speedOf(const btSolverConstraint& r, const std::vector<Velocity>& v) const {
    double sum = 0;
    if (r.m_solverBodyIdA > 0)
      sum += r.m_contactNormal1.dot(v[r.m_solverBodyIdA - 1].linear) +
             r.m_relpos1CrossNormal.dot(v[r.m_solverBodyIdA - 1].angular);
    if (r.m_solverBodyIdB > 0)
      sum += r.m_contactNormal2.dot(v[r.m_solverBodyIdB - 1].linear) +
             r.m_relpos2CrossNormal.dot(v[r.m_solverBodyIdB - 1].angular);
    return sum;
  }
  void push(const btSolverConstraint& r, double impulse, std::vector<Velocity>& v) const {
    const auto x = static_cast<btScalar>(impulse);
    for (const auto& [id, way, turn] :
         {std::tuple(r.m_solverBodyIdA, r.m_contactNormal1, r.m_relpos1CrossNormal),
          std::tuple(r.m_solverBodyIdB, r.m_contactNormal2, r.m_relpos2CrossNormal)})
      if (id > 0) {
        v[id - 1].linear += way * x;
        v[id - 1].angular += turn * (10 * x);  // over the inertia
      }
  }
  static double energyOf(const std::vector<Velocity>& v) {
    double sum = 0;
    for (const Velocity& one : v) sum += one.linear.length2() + 0.1 * one.angular.length2();
    return sum / 2;
  }

  std::mt19937 random;
  std::uniform_real_distribution<double> any{-1, 1};
  btSphereShape shape{0.3f};
  std::vector<std::unique_ptr<btRigidBody>> rigid;
  btAlignedObjectArray<btSolverBody> bodies;
  std::vector<Velocity> speeds;
  btConstraintArray joints, contacts, frictions, rolling;
};

TEST(NewtonRows, WhatIsJammedObeysCoulombAndGainsNothing) {
  double lacks = 0, holds = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    Jam jam(seed, 20, 60 + 2 * int(seed % 20), 0.2 + 0.02 * (seed % 50));
    NewtonRows rows;
    const std::vector<double> x =
        rows.solve({jam.joints, jam.contacts, jam.frictions, jam.rolling}, jam.bodies, kSpeed);
    std::vector<Jam::Velocity> after = jam.speeds;
    const int count = jam.contacts.size();
    for (int i = 0; i < count; ++i) jam.push(jam.contacts[i], x[i], after);
    for (int i = 0; i < 2 * count; ++i) jam.push(jam.frictions[i], x[count + i], after);
    EXPECT_LE(jam.energyOf(after), jam.energyOf(jam.speeds));
    for (int i = 0; i < count; ++i) {
      const double wants = std::max(0.0, -jam.speedOf(jam.contacts[i], after) / kSoft);
      EXPECT_NEAR(kSoft * x[i], kSoft * wants, kSpeed);
    }
    for (int i = 0; i < 2 * count; ++i) {
      const btSolverConstraint& row = jam.frictions[i];
      const double slip = jam.speedOf(row, after), pull = x[count + i];
      const double most = row.m_friction * x[row.m_frictionIndex];
      EXPECT_LE(kSoft * std::abs(pull), kSoft * most + kSpeed);
      EXPECT_LE(std::copysign(slip, slip * pull), kSpeed) << "against the slip";
      if (std::abs(slip + kSoft * pull) > kSpeed) lacks += most - std::abs(pull);
      holds += most;
    }
  }
  EXPECT_LT(lacks, 0.1 * holds) << "friction that holds less than it could";
}

}  // namespace
}  // namespace cloudcontact::testing::newton_rows_test
