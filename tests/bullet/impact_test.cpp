// Restitution against its definition, at any step: the speed after an impact over that before it,
// the time of a series of bounces, and that what rests or states a damping does not bounce.
#include "bullet/step_adjustments.h"

#include <cloudcontact/bullet/newton_solver.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bullet/bullet_world.h"

namespace cloudcontact::testing::impact_test {
namespace {

constexpr double kVoxel = 0.01, kGravity = 9.81, kHeight = 0.5;
constexpr double kRates[] = {60, 240, 1000};  // [Hz]

struct Drop {
  double rebound = 0;  // root of the height after the first bounce over that before: of the speeds
  double deepest = 0;  // [m]
  double still = 0;    // [s] when it last moved faster than 5 cm/s
};

struct Dropped {
  std::shared_ptr<const SurfaceField> field;
  double half;   // its height over its lowest point [m]
  bool onCloud;  // else on Bullet's plane
};

Dropped ball(bool onCloud) {
  static const auto field = fieldOf(sphereMesh(0.1, 1e-5), kVoxel);
  return {field, 0.1, onCloud};
}
Dropped box(bool onCloud) {
  static const auto field = fieldOf(boxMesh({0.2, 0.2, 0.1}), kVoxel);
  return {field, 0.05, onCloud};
}

Drop drop(const Dropped& what, double restitution, double rate, double seconds,
          const CloudContactSettings& settings = {}) {
  static const auto slab = fieldOf(boxMesh({1, 1, 0.2}), 2 * kVoxel);
  BulletWorld scene(settings);
  btRigidBody& floor =
      what.onCloud ? scene.addCloud(slab, 0, at({0, 0, btScalar(-0.1)})) : scene.addGround();
  floor.setRestitution(1);
  btRigidBody& body = scene.addCloud(what.field, 1, at({0, 0, btScalar(kHeight + what.half)}));
  body.setRestitution(btScalar(restitution));
  Drop found;
  double peak = 0, before = 0;
  int bounces = 0;
  for (int i = 0; i < seconds * rate; ++i) {
    scene.step(1 / rate);
    const double speed = body.getLinearVelocity().z(),
                 z = body.getWorldTransform().getOrigin().z() - what.half;
    bounces += before < -0.1 && speed >= 0;
    if (bounces == 1) peak = std::max(peak, z);
    found.deepest = std::max(found.deepest, -z);
    if (std::abs(speed) > 0.05) found.still = (i + 1) / rate;
    before = speed;
  }
  found.rebound = std::sqrt(std::max(0.0, peak) / kHeight);
  return found;
}

TEST(Impact, ReboundsAsStated) {
  for (const double rate : kRates)
    for (const double restitution : {0.3, 0.6, 0.9})
      for (const Dropped& what : {ball(false), box(false), ball(true), box(true)}) {
        const double found = drop(what, restitution, rate, 1).rebound;
        EXPECT_NEAR(found, restitution, 0.02 * restitution)
            << rate << " Hz, " << what.half << (what.onCloud ? " m on a cloud" : " m on a plane");
      }
}

// Cubes that meet face to face in the middle: their speeds are those of two points, and no step,
// voxel or restitution turns them, nor a touch exactly at the end of a step (10 mm at 1 m/s).
// Automatic springs, which bounce a little, let them rock.
TEST(Impact, FlatFacesTurnNothing) {
  constexpr double kEdge = 0.04, kMassA = 0.2, kMassB = 0.3, kMass = kMassA + kMassB;
  for (const double voxel : {0.001, 0.002, 0.003}) {
    const auto cube = fieldOf(boxMesh({kEdge, kEdge, kEdge}), voxel);
    for (const auto& [rate, apart] :
         {std::pair(240.0, 0.0103), {1000.0, 0.0103}, {1000.0, 0.01}, {4000.0, 0.0103}})
      for (const double e : {0.0, 0.5, 1.0}) {
        SCOPED_TRACE(std::to_string(rate) + " Hz, e = " + std::to_string(e));
        BulletWorld scene;
        NewtonSolver sweeps;
        scene.world.setConstraintSolver(&sweeps);
        scene.world.setGravity({0, 0, 0});
        btRigidBody& a = scene.addCloud(cube, kMassA, at({0, 0, 0}));
        btRigidBody& b = scene.addCloud(cube, kMassB, at({btScalar(kEdge + apart), 0, 0}));
        a.setLinearVelocity({1, 0, 0});
        for (btRigidBody* body : {&a, &b}) {
          body->setRestitution(btScalar(std::sqrt(e)));
          body->setFriction(0);
        }
        double turns = 0;
        for (int i = 0; i < 0.06 * rate; ++i) {
          scene.step(1 / rate);
          for (const btRigidBody* body : {&a, &b})
            turns = std::max(turns, double(body->getAngularVelocity().length()));
        }
        EXPECT_LT(turns, e > 0 ? 1e-3 : 0.2);
        const double most = e > 0 ? 1e-4 : 0.02;
        EXPECT_NEAR(a.getLinearVelocity().x(), (kMassA - e * kMassB) / kMass, most);
        EXPECT_NEAR(b.getLinearVelocity().x(), (1 + e) * kMassA / kMass, most);
        scene.world.setConstraintSolver(&scene.solver);
      }
  }
}

TEST(Impact, WithoutRestitutionNothingBounces) {
  for (const double rate : kRates)
    for (const Dropped& what : {ball(false), box(false), ball(true), box(true)})
      EXPECT_LT(drop(what, 0, rate, 1).rebound, 0.05) << rate << ' ' << what.half;
}

// Flat faces a tenth of a voxel apart are seen before they meet: nothing sinks in by a step's way.
TEST(Impact, NothingSinksInWhereItMayBounce) {
  for (const double rate : {240.0, 1000.0})
    for (const Dropped& what : {ball(false), box(false), ball(true), box(true)})
      EXPECT_LT(drop(what, 0.3, rate, 1).deepest, 0.15 * kVoxel) << rate << ' ' << what.half;
}

// Bounces follow each other at e times the time: all take v / g (1 + 2 e / (1 - e)). At 60 Hz the
// part of a step at which each falls moves the end by up to 0.4 s, by chance: the mean of rates.
// The last bounces, below 5 cm/s, take 1.7 % of it and are not seen.
TEST(Impact, ABallComesToRestInTheTimeOfTheSeries) {
  const double fall = std::sqrt(2 * kHeight / kGravity), e = 0.9;
  const double series = fall * (1 + 2 * e / (1 - e));
  for (const double rate : kRates) {
    double mean = 0;
    for (int k = -4; k <= 4; ++k) mean += drop(ball(false), e, (1 + 0.01 * k) * rate, 8).still / 9;
    EXPECT_NEAR(mean, series, 0.04 * series) << rate;
  }
}

TEST(Impact, AStatedDampingOrABodyAtRestTakesNone) {
  CloudContactSettings damped;
  damped.law = KelvinVoigt{1e5, 2 * std::sqrt(1e5)};
  EXPECT_LT(drop(ball(false), 0.9, 1000, 1, damped).rebound, 0.2);
  BulletWorld scene;
  scene.addGround().setRestitution(1);
  btRigidBody& cube = scene.addCloud(box(false).field, 1, at({0, 0, btScalar(0.05)}));
  cube.setRestitution(btScalar(0.9));
  for (int i = 0; i < 240; ++i) scene.step(1. / 240);
  EXPECT_LT(std::abs(cube.getLinearVelocity().z()), 1e-4);
  for (const btManifoldPoint& point : scene.points())
    EXPECT_TRUE(point.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING);
}

// The speed with which a ball that meets a plane at 1 leaves it again, without gravity. `gap`: at
// the beginning, of the way of a step.
double returned(double stiffness, double damping, double step, double gap) {
  CloudContactSettings settings;
  settings.law = KelvinVoigt{stiffness, damping};
  BulletWorld scene(settings);
  scene.world.setGravity({0, 0, 0});
  scene.addGround();
  const double speed = 0.25;  // [m/s]
  btRigidBody& body =
      scene.addCloud(ball(false).field, 1, at({0, 0, btScalar(0.1 + gap * speed * step)}));
  body.setLinearVelocity({0, 0, btScalar(-speed)});
  for (int i = 0; i < 10 / (step * std::sqrt(stiffness)); ++i) scene.step(step);
  return body.getLinearVelocity().z() / speed;
}

// The same of a point by hand: rows of backward Euler with damping ratio z, `wh` the step times the
// spring's frequency, which push k d + c v of the depth and speed at the step's end, and where the
// step begins apart, of the way behind the touch.
double rowsReturn(double z, double wh, double gap) {
  double x = gap * wh, v = 1;  // in the time 1 / w: to the plane, and toward it
  for (int i = 0; i < 10 / wh; ++i) {
    const double grows = wh + 2 * z, free = std::max(0.0, x / wh), in = std::max(0.0, -x);
    const double after = (v + wh * (grows * free - in)) / (1 + wh * grows);
    if (in + grows * (after - free) > 0) v = after;  // it never pulls
    x -= wh * v;
  }
  return -v;
}

// docs/engine.md, "Restitution": in closed form, of a spring that never pulls, with damping ratio
// z.
double springReturns(double z) {
  const double root = std::sqrt(std::abs(1 - z * z));
  return std::exp(-2 * z * (z < 1 ? std::acos(z) : std::acosh(z)) / root);
}

// The step adds w h / 2 to the damping ratio.
TEST(Impact, ADampedSpringReturnsWhatLawAndStepSay) {
  const double k = 1e4, w = 100;  // of 1 kg
  const std::pair<double, double> bounds[] = {{0.02, 0.002}, {0.1, 0.009}, {0.3, 0.03}, {1, 0.05}};
  for (const double z : {0.0, 0.1, 0.36, 0.7, 1.5})
    for (const auto& [wh, bound] : bounds)
      for (const double gap : {0.1, 0.5, 0.9}) {
        const double rows = rowsReturn(z, wh, gap);
        EXPECT_NEAR(returned(k, 2 * z * w, wh / w, gap), rows, std::min(0.01, 0.006 + 0.01 * wh))
            << z << ' ' << wh << ' ' << gap;
        EXPECT_NEAR(rows, springReturns(z + wh / 2), bound) << z << ' ' << wh << ' ' << gap;
      }
}

// By hand: without gravity the speed is e times; with it the energy at the touch counts, in steps.
TEST(Impact, TheSpeedIsThatOfATouchBetweenTwoSteps) {
  EXPECT_NEAR(bounceSpeed(0.7, 3, -0.01, 0, 0.01), 2.1, 1e-12);
  for (const double e : {0.5, 1.0})
    for (const double gap : {-0.004, 0.0, 0.02}) {
      const double v = 2, g = kGravity, h = 1. / 240;
      const double out = bounceSpeed(e, v, -gap, g, h);
      const double down = v * v / 2 + g * gap + g * h * v / 2;
      EXPECT_NEAR(out * out / 2 + g * gap + g * h * out / 2, e * e * down, 1e-9) << e << ' ' << gap;
    }
}

}  // namespace
}  // namespace cloudcontact::testing::impact_test
