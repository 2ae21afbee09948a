// NewtonSolver against the solution of the rows, closed forms that Bullet's own sweeps miss,
// friction's limits and its spring.
#include <cloudcontact/bullet/newton_solver.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bullet/bullet_world.h"

namespace cloudcontact::testing::newton_solver_test {
namespace {

constexpr double kVoxel = 0.1, kGravity = 9.81, kStep = 1. / 60;

std::shared_ptr<const SurfaceField> cubeField() {
  static const auto field = fieldOf(boxMesh({1, 1, 1}), kVoxel);
  return field;
}

CloudContactSettings stated(double stiffness, double damping) {
  CloudContactSettings settings;
  settings.law = KelvinVoigt{stiffness, damping};
  return settings;
}

// A world with this solver or Bullet's own.
struct SolvedWorld : BulletWorld {
  explicit SolvedWorld(bool ours, const CloudContactSettings& settings = {})
      : BulletWorld(settings) {
    sweeps.newton = ours;
    world.setConstraintSolver(&sweeps);
  }
  ~SolvedWorld() { world.setConstraintSolver(&solver); }
  NewtonSolver sweeps;
};

// A ton on a kilogram, each spring 1e6 N/m: the largest error of the ton's height within a second,
// in sags of the lower spring.
double worstOff(bool ours) {
  const double stiffness = 1e6;
  SolvedWorld scene(ours, stated(stiffness, 2 * std::sqrt(stiffness * 1000)));
  scene.addGround();
  const double lower = 1001 * kGravity / stiffness, upper = 1000 * kGravity / stiffness;
  scene.addCloud(cubeField(), 1, at({0, 0, btScalar(0.5 - lower)}));
  btRigidBody& ton = scene.addCloud(cubeField(), 1000, at({0, 0, btScalar(1.5 - lower - upper)}));
  double worst = 0;
  for (int i = 0; i < 60; ++i) {
    scene.step(kStep);
    const double z = ton.getWorldTransform().getOrigin().z();
    worst = std::max(worst, std::abs(z - (1.5 - lower - upper)) / lower);
  }
  return worst;
}

TEST(NewtonSolver, HoldsATonOnAKilogramWhereBulletsOwnSweepsSink) {
  EXPECT_LT(worstOff(true), 0.2);
  EXPECT_GT(worstOff(false), 10);
}

// The impulses of a column's first step after so many sweeps, without warm starting.
std::vector<double> impulsesOf(bool ours, int sweeps) {
  SolvedWorld scene(ours, stated(1e7, 1e5));
  scene.world.getSolverInfo().m_numIterations = sweeps;
  scene.sweeps.mostSweeps = 0;
  scene.addGround();
  for (int i = 0; i < 6; ++i)
    scene.addCloud(cubeField(), i % 2 ? 100 : 10, at({0, 0, btScalar(0.499 + 0.999 * i)}));
  scene.step(kStep);
  std::vector<double> impulses;
  for (const btManifoldPoint& p : scene.points()) impulses.push_back(p.m_appliedImpulse);
  return impulses;
}

double farFrom(const std::vector<double>& solution, const std::vector<double>& found) {
  double off = 0, all = 0;
  for (std::size_t i = 0; i < solution.size(); ++i) {
    off += std::pow(found[i] - solution[i], 2);
    all += std::pow(solution[i], 2);
  }
  return std::sqrt(off / all);
}

// Relative error after 30 and 100 of Bullet's own sweeps: 0.53 and 0.39.
TEST(NewtonSolver, FindsInTwoSweepsWhatFiveThousandDo) {
  const auto solution = impulsesOf(false, 5000);
  ASSERT_GE(solution.size(), 24u);
  EXPECT_GT(farFrom(solution, impulsesOf(false, 100)), 0.3);
  EXPECT_LT(farFrom(solution, impulsesOf(true, 2)), 1e-3);
}

TEST(NewtonSolver, OneSweepIsBulletsToTheBit) {
  EXPECT_EQ(impulsesOf(true, 1), impulsesOf(false, 1));
  SolvedWorld plain(false, stated(1e7, 1e5));
  EXPECT_EQ(plain.sweeps.getSolverType(), BT_SEQUENTIAL_IMPULSE_SOLVER);
  EXPECT_TRUE(diagnose(plain.world).empty());
}

// Two bodies slide, light under heavy: no point pulls, no friction exceeds mu times its push, and
// the heavy one decelerates by mu g.
TEST(NewtonSolver, KeepsLimits) {
  const double mu = 0.2, seconds = 20 * kStep;
  SolvedWorld scene(true, stated(1e6, 1e4));
  scene.addGround().setFriction(1);
  btRigidBody& lower = scene.addCloud(cubeField(), 5, at({0, 0, btScalar(0.5)}));
  btRigidBody& upper = scene.addCloud(cubeField(), 50, at({0, 0, btScalar(1.5)}));
  lower.setFriction(btScalar(mu));
  upper.setFriction(1);
  for (btRigidBody* body : {&lower, &upper}) body->setLinearVelocity({2, 0, 0});
  for (int i = 0; i < 20; ++i) {
    scene.step(kStep);
    for (const btManifoldPoint& p : scene.points()) {
      EXPECT_GE(p.m_appliedImpulse, 0);
      if (!(p.m_appliedImpulse > 0)) continue;  // Bullet does not update such a point's friction
      const double most = p.m_combinedFriction * p.m_appliedImpulse * (1 + 1e-4);
      EXPECT_LE(std::abs(p.m_appliedImpulseLateral1), most);
      EXPECT_LE(std::abs(p.m_appliedImpulseLateral2), most);
    }
  }
  const double speed = 2 - mu * kGravity * seconds;
  EXPECT_NEAR(upper.getLinearVelocity().x(), speed, 0.1 * speed);
}

TEST(NewtonSolver, TheSameWorldTwiceIsTheSameToTheBit) {
  EXPECT_EQ(impulsesOf(true, 10), impulsesOf(true, 10));
}

double mechanicalEnergy(const btRigidBody& body) {
  const btVector3 turn =
      body.getWorldTransform().getBasis().transpose() * body.getAngularVelocity();
  return 0.5 * body.getLinearVelocity().length2() / body.getInvMass() +
         0.5 * turn.dot(turn * body.getLocalInertia()) +
         kGravity * body.getWorldTransform().getOrigin().z() / body.getInvMass();
}

// A load along a plane moves what stands on it by the load over the points' springs, ten times
// their normals', for as long as it acts; then it is where it was. Rigid rows creep, as what one
// step's sweeps leave is lost.
TEST(NewtonSolver, FrictionIsASpringThatHoldsAndReturns) {
  const double stiffness = 1e5, load = 2;
  SolvedWorld scene(true, stated(stiffness, 100));
  scene.addGround();
  btRigidBody& cube = scene.addCloud(cubeField(), 1, at({0, 0, btScalar(0.5)}));
  cube.setFriction(1);
  const auto moved = [&](double force, double seconds) {
    for (int i = 0; i < seconds / kStep; ++i) {
      cube.applyForce({btScalar(force), 0, 0}, {0, 0, btScalar(-0.5)});  // no tilt
      scene.step(kStep);
    }
    return double(cube.getWorldTransform().getOrigin().x());
  };
  const double start = moved(0, 1), held = load / (10 * stiffness);
  EXPECT_NEAR(moved(load, 1) - start, held, 0.1 * held);
  EXPECT_NEAR(moved(load, 20) - start, held, 0.1 * held);
  EXPECT_NEAR(moved(0, 1) - start, 0, 0.1 * held);
}

// Boxes that fall into a heap, on and between each other, two seconds long: the solver's sweeps and
// Newton's steps for each solution, in the mean. Expects that no energy is gained.
struct HeapPrice {
  double sweeps, newton;
};
HeapPrice priceOfHeap(double rate) {
  static const auto field = fieldOf(boxMesh({0.11, 0.07, 0.05}), 4e-3);
  CloudContactSettings settings;
  settings.bears = 100;
  SolvedWorld scene(true, settings);
  scene.addGround().setFriction(btScalar(0.6));
  std::vector<btRigidBody*> bodies;
  for (int i = 0; i < 24; ++i) {
    const double turn = 0.7 * i;
    bodies.push_back(&scene.addCloud(
        field, 1,
        at({btScalar(0.05 * (i % 3)), btScalar(0.04 * (i % 2)), btScalar(0.1 + 0.15 * i)},
           btQuaternion(btVector3(1, btScalar(0.3), btScalar(0.5)).normalized(), btScalar(turn)))));
    bodies.back()->setFriction(btScalar(0.6));
  }
  const auto energy = [&] {
    double sum = 0;
    for (const btRigidBody* body : bodies) sum += mechanicalEnergy(*body);
    return sum;
  };
  const double start = energy();
  for (int i = 0; i < 2 * rate; ++i) {
    scene.step(1 / rate);
    EXPECT_LT(energy(), start * (1 + 1e-6));
  }
  const auto islands = double(scene.sweeps.islands());
  return {double(scene.sweeps.sweeps()) / islands, double(scene.sweeps.steps()) / islands};
}

// Rows of many patches and of rings of bodies agree after two sweeps in the mean. With rigid rows
// of friction they hardly ever do.
TEST(NewtonSolver, RowsOfAHeapAgree) {
  EXPECT_LT(priceOfHeap(240).sweeps, 2.2);
}

// In long steps friction presses what it lies on: limits that only follow the impulses close in by
// a tenth a step, and end before they agree.
TEST(NewtonSolver, FrictionOfAHeapAgreesInLongSteps) {
  const HeapPrice price = priceOfHeap(60);
  EXPECT_LT(price.sweeps, 2.6);  // 2.52; with limits that follow alone 2.66
  EXPECT_LT(price.newton, 73);   // 69 and 77
}

// How a tower of bricks stands, turned by 0, 0.2 and 0.4 rad in turn, 4 mm voxels.
struct Tower {
  double away = 0, sunk = 0;  // of the top brick: aside and below where it stood [m], at the end
  double gained = 0;          // [J] kinetic and potential energy above the start's, at most
  double sweeps = 0;          // a step, in the mean
};

struct TowerSettings {
  int bricks;
  double stiffness;  // [N/m] of each body; 0: automatic
  double rate;       // [Hz]
};

Tower stand(const TowerSettings& how, double seconds) {
  static const auto field = fieldOf(boxMesh({0.11, 0.07, 0.05}), 4e-3);
  CloudContactSettings settings;
  settings.bears = 100;
  SolvedWorld scene(true, settings);
  std::vector<btRigidBody*> bodies{&scene.addGround()};
  for (int i = 0; i < how.bricks; ++i)
    bodies.push_back(
        &scene.addCloud(field, 1,
                        at({0, 0, btScalar(0.05 * (i + 0.5))},
                           btQuaternion(btVector3(0, 0, 1), btScalar(0.2 * (i % 3))))));
  for (btRigidBody* body : bodies) {
    body->setFriction(btScalar(0.6));
    if (how.stiffness > 0)
      body->setContactStiffnessAndDamping(btScalar(how.stiffness),
                                          btScalar(0.2 * std::sqrt(how.stiffness)));
  }
  bodies.erase(bodies.begin());
  const auto energy = [&] {
    double sum = 0;
    for (const btRigidBody* body : bodies) sum += mechanicalEnergy(*body);
    return sum;
  };
  Tower tower;
  const double start = energy();
  for (int i = 0; i < how.rate * seconds; ++i) {
    scene.step(1 / how.rate);
    tower.gained = std::max(tower.gained, energy() - start);
  }
  const btVector3 top = bodies.back()->getWorldTransform().getOrigin();
  tower.away = std::hypot(top.x(), top.y());
  tower.sunk = 0.05 * (how.bricks - 0.5) - top.z();
  tower.sweeps = double(scene.sweeps.sweeps()) / double(scene.sweeps.islands());
  return tower;
}

// With ten sweeps 12 of these fall within half a second and gain 70 times their energy; with
// anchors that pull every way 10 of them fall after six.
TEST(NewtonSolver, TowersStandAndGainNothing) {
  for (const TowerSettings& how : {TowerSettings{10, 4e6, 120}, TowerSettings{12, 1e6, 60},
                                   TowerSettings{12, 4e6, 240}, TowerSettings{20, 4e6, 60}}) {
    const Tower tower = stand(how, 10);
    EXPECT_LT(tower.away, 0.1 * 4e-3) << how.bricks << ' ' << how.stiffness << ' ' << how.rate;
    EXPECT_LT(tower.sunk, 0.5 * 4e-3) << how.bricks << ' ' << how.stiffness << ' ' << how.rate;
    EXPECT_LT(tower.gained, 1e-4 * kGravity * 0.025 * how.bricks * how.bricks);
    EXPECT_LT(tower.sweeps, 2.2) << how.bricks << ' ' << how.stiffness << ' ' << how.rate;
  }
}

// Cubes of 12 cm straight on each other. Sweeps that ended before rows agreed dropped them.
TEST(NewtonSolver, CratesStandInAnyStep) {
  static const auto field = fieldOf(boxMesh({0.12, 0.12, 0.12}), 6e-3);
  for (const double damping : {0., 600., 2000.})
    for (const double rate : {60., 60.2, 59.5, 66.7, 120., 240.}) {
      SolvedWorld scene(true, stated(5e5, damping / 2));
      scene.addGround().setFriction(btScalar(0.5));
      std::vector<btRigidBody*> bodies;
      for (int i = 0; i < 8; ++i) {
        bodies.push_back(&scene.addCloud(field, 1, at({0, 0, btScalar(0.06 + 0.12 * i)})));
        bodies.back()->setFriction(btScalar(0.5));
      }
      double gained = 0, start = 0;
      for (const btRigidBody* body : bodies) start += mechanicalEnergy(*body);
      for (int i = 0; i < 2 * rate; ++i) {
        scene.step(1 / rate);
        double energy = -start;
        for (const btRigidBody* body : bodies) energy += mechanicalEnergy(*body);
        gained = std::max(gained, energy);
      }
      const btVector3 top = bodies.back()->getWorldTransform().getOrigin();
      EXPECT_LT(gained, 1e-5 * start) << damping << ' ' << rate;
      EXPECT_NEAR(top.z(), 0.9, 2e-3) << damping << ' ' << rate;
      EXPECT_LT(std::hypot(top.x(), top.y()), 1e-3) << damping << ' ' << rate;
    }
}

// The joints' sags add up: with a sag of 0.025 voxel under a brick's own weight 12 are a voxel
// lower, and the pair's own mass as the limit drops them at 120 Hz.
TEST(NewtonSolver, TowersOnAutomaticSpringsStandAsHigh) {
  for (const TowerSettings& how :
       {TowerSettings{10, 0, 240}, TowerSettings{12, 0, 60}, TowerSettings{12, 0, 120}}) {
    const Tower tower = stand(how, 5);
    EXPECT_LT(tower.away, 0.1 * 4e-3) << how.bricks << ' ' << how.rate;
    EXPECT_LT(tower.sunk, 0.5 * 4e-3) << how.bricks << ' ' << how.rate;
    EXPECT_LT(tower.gained, 1e-4 * kGravity * 0.025 * how.bricks * how.bricks);
  }
}

// A tower buckles where (N a)^3 > 7.84 (k w^2 / 12) a^2 / (m g), as columns do (docs/limits.md): on
// pair springs of 5e4 N/m, w 0.07 m, beyond 8 bricks.
TEST(NewtonSolver, TowersOnSoftSpringsBuckleAsColumnsDo) {
  EXPECT_LT(stand({6, 1e5, 60}, 5).away, 0.1 * 4e-3);
  EXPECT_GT(stand({12, 1e5, 60}, 5).away, 0.05);
}

// The largest depth of a body under a load that is released on it, with the automatic spring.
double deepestUnderATon(double bears, double step) {
  CloudContactSettings settings;
  settings.bears = bears;
  SolvedWorld scene(true, settings);
  scene.addGround();
  btRigidBody& light = scene.addCloud(cubeField(), 1, at({0, 0, btScalar(0.5)}));
  btRigidBody& ton = scene.addCloud(cubeField(), 1000, at({0, 0, btScalar(1.5)}));
  double deepest = 0;
  for (int i = 0; i < 2 / step; ++i) {
    scene.step(step);
    const double low = light.getWorldTransform().getOrigin().z(),
                 high = ton.getWorldTransform().getOrigin().z();
    deepest = std::max({deepest, 0.5 - low, 1 - (high - low)});
  }
  return deepest / kVoxel;
}

TEST(Bears, ALightBodyBearsAThousandTimesItsMassOnlyWithTheSetting) {
  EXPECT_LT(deepestUnderATon(100, 1. / 240), 0.5);
  EXPECT_GT(deepestUnderATon(1, 1. / 240), 0.6);
}

TEST(Bears, IsOneAtLeast) {
  for (const double wrong :
       {0.0, 0.99, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    CloudContactSettings settings;
    settings.bears = wrong;
    EXPECT_THROW(CloudContact{settings}, std::invalid_argument) << wrong;
  }
}

}  // namespace
}  // namespace cloudcontact::testing::newton_solver_test
