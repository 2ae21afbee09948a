// All that goes to Bullet is a number: springs, depths, normals and friction of every point, and
// the bodies that it moves, in worlds of all laws, with tolerances and without.
#include <cloudcontact/field/field_levels.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "bullet/bullet_world.h"
#include "bullet/solid_meshes.h"
#include "mesh/thread_meshes.h"

namespace cloudcontact::testing::finite_points_test {
namespace {

using Levels = std::shared_ptr<const FieldLevels>;

Levels levelsOf(const Mesh& mesh, double voxel) {
  DigitizeSettings how;
  how.voxelSize = voxel;
  how.threads = 1;
  FieldSettings fields;
  fields.threads = 1;
  return std::make_shared<const FieldLevels>(digitize(mesh, how), fields);
}

// An L about its center of mass.
Mesh bracket(double x, double y, double thick, double height) {
  Pose pose;
  pose.position = -matterOfBoxes(angleBoxes(x, y, thick, height)).centerOfMass;
  return transformed(angleMesh(x, y, thick, height), pose);
}

Mesh pipe(double inner, double outer, double length) {
  return revolvedMesh(40, 24, true, [&](double angle, double s) {
    const bool inside = s < 0.5;
    const double z = length * ((inside ? 2 * s : 2 - 2 * s) - 0.5), r = inside ? inner : outer;
    return Vec3(r * std::cos(angle), r * std::sin(angle), z);
  });
}

// An L does not turn about its axes, which is no matter here.
CloudContactSettings quiet() {
  CloudContactSettings settings;
  settings.onFailure = [](const std::string&) {};
  return settings;
}

btTransform placed(const Vec3& place, const Eigen::Quaterniond& turn) {
  const Eigen::Matrix<btScalar, 4, 1> q = turn.coeffs().cast<btScalar>();
  const Eigen::Matrix<btScalar, 3, 1> x = place.cast<btScalar>();
  return at({x[0], x[1], x[2]}, {q[0], q[1], q[2], q[3]});
}

bool isFinite(const btVector3& v) {
  return std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z());
}

// Empty if all of a point are numbers, its directions have length 1, and its spring resists.
std::string wrongIn(const btManifoldPoint& p, double step) {
  for (const btVector3* at :
       {&p.m_localPointA, &p.m_localPointB, &p.m_positionWorldOnA, &p.m_positionWorldOnB})
    if (!isFinite(*at)) return "a place";
  for (const btVector3* way :
       {&p.m_normalWorldOnB, &p.m_lateralFrictionDir1, &p.m_lateralFrictionDir2})
    if (!(std::abs(double(way->length()) - 1) < 1e-3)) return "a direction";
  if (!std::isfinite(p.m_distance1)) return "the depth";
  for (const btScalar value :
       {p.m_combinedFriction, p.m_combinedRestitution, p.m_contactMotion1, p.m_contactMotion2,
        p.m_appliedImpulse, p.m_appliedImpulseLateral1, p.m_appliedImpulseLateral2, p.m_contactERP})
    if (!std::isfinite(value)) return "friction, restitution or an impulse";
  if (!(p.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING)) return {};
  const double k = p.m_combinedContactStiffness1, c = p.m_combinedContactDamping1;
  if (!std::isfinite(k) || !std::isfinite(c)) return "the spring";
  if (!(k >= 0) || !(step * k + c >= -1e-5 * step * k)) return "the spring pulls";
  return {};
}

std::string wrongIn(const BulletWorld& scene, double step) {
  for (const btManifoldPoint& point : scene.points())
    if (std::string wrong = wrongIn(point, step); !wrong.empty()) return wrong + " of a point";
  const btCollisionObjectArray& objects = scene.world.getCollisionObjectArray();
  for (int i = 0; i < objects.size(); ++i) {
    const btRigidBody& body = *btRigidBody::upcast(objects[i]);
    const btTransform& place = body.getWorldTransform();
    for (const btVector3& v :
         {place.getOrigin(), place.getBasis()[0], place.getBasis()[1], place.getBasis()[2],
          body.getLinearVelocity(), body.getAngularVelocity()})
      if (!isFinite(v)) return "a body";
  }
  return scene.clouds.statistics().lastFailure;
}

void expectFinite(BulletWorld& scene, double step, int steps) {
  for (int i = 0; i < steps; ++i) {
    scene.step(step);
    ASSERT_EQ(wrongIn(scene, step), "") << "in step " << i;
  }
}

// Levels change while it falls, turns and lands, and the depth of those before fades away: all
// patches that touch may be apart by then.
TEST(FinitePoints, OfABracketThatFallsOnABoxAtATolerance) {
  const double size = 0.24, voxel = 4e-3, steps[] = {1. / 60, 1. / 120, 1. / 240, 1. / 480};
  const Levels falling = levelsOf(bracket(size, size, 0.04, 0.05), voxel),
               under = levelsOf(boxMesh({0.4, 0.4, 0.1}), voxel);
  for (std::uint64_t drop = 0; drop < 60; ++drop) {
    SCOPED_TRACE("drop " + std::to_string(drop));
    Random random(100 * drop + 7);
    CloudContactSettings settings = quiet();
    settings.fidelity.tolerance = size * random.uniform(0.0125, 0.02);
    BulletWorld scene(settings);
    scene.add(std::make_unique<CloudShape>(under), 0, at({0, 0, btScalar(-0.05)}));
    scene.add(std::make_unique<CloudShape>(falling), 0.7, placed({0, 0, 0.2}, random.rotation()));
    const double step = steps[drop % 4];
    expectFinite(scene, step, static_cast<int>(0.6 / step));
  }
}

// Bodies of 2 to 6 cm: an L, a pipe, an egg, a box, and a ball.
const std::array<Levels, 5>& bodies() {
  static const std::array<Levels, 5> all = [] {
    constexpr double kVoxel = 2e-3;
    Mesh egg = sphereMesh(16e-3, 1e-4);
    for (Vec3& v : egg.vertices) v = v.cwiseProduct(Vec3(1, 1.4, 0.9));
    return std::array<Levels, 5>{levelsOf(bracket(60e-3, 40e-3, 14e-3, 16e-3), kVoxel),
                                 levelsOf(pipe(9e-3, 20e-3, 40e-3), kVoxel), levelsOf(egg, kVoxel),
                                 levelsOf(boxMesh({50e-3, 30e-3, 24e-3}), kVoxel),
                                 levelsOf(sphereMesh(18e-3, 1e-4), kVoxel)};
  }();
  return all;
}

// Every law, with damping and without. The first is the automatic spring.
std::vector<std::optional<Law>> laws() {
  return {std::nullopt,
          std::nullopt,
          KelvinVoigt{5e3, 0},
          KelvinVoigt{2e4, 10},
          Foundation{1e8, 1e4},
          Foundation{1e9, 0},
          Foundation{},
          Maxwell{5e3, 50},
          StandardLinearSolid{2e3, 4e3, 20},
          TableLaw{{{1e-3, 5}, {2e-3, 40}}, 1},
          TableLaw{{{0, 2}, {1e-3, 6}}, 0},  // pushes at the first touch
          UserLaw{[](double depth, double rate) { return 1e5 * depth * (1 + rate); }},
          UserLaw{[](double, double) { return 3.; }},
          Rigid{}};
}

double powerOf(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform());
}

// Five bodies thrown together above a floor, some of which begin in each other.
struct Heap {
  explicit Heap(std::uint64_t seed) : random(seed), scene(settingsOf(random, seed)) {
    if (seed % 3 == 0)
      scene.addGround();
    else
      scene.add(std::make_unique<CloudShape>(bodies()[3]), 0, at({0, 0, btScalar(-12e-3)}));
    for (int i = 0; i < 5; ++i) {
      const auto kind = static_cast<std::size_t>(5 * random.uniform());
      auto shape = std::make_unique<CloudShape>(bodies()[kind]);
      if (random.uniform() < 0.3) shape->setFidelity({powerOf(random, 5e-5, 3e-3)});
      const Vec3 place(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), 0.02 + 0.03 * i);
      btRigidBody& body =
          scene.add(std::move(shape), powerOf(random, 0.01, 10), placed(place, random.rotation()));
      const Vec3 v = random.inCube() - Vec3(0.5, 0.5, 1), w = 20 * random.inCube();
      body.setLinearVelocity({btScalar(v.x()), btScalar(v.y()), btScalar(v.z())});
      body.setAngularVelocity({btScalar(w.x()), btScalar(w.y()), btScalar(w.z())});
      if (random.uniform() < 0.3) body.setRestitution(btScalar(random.uniform()));
    }
  }
  static CloudContactSettings settingsOf(Random& random, std::uint64_t seed) {
    CloudContactSettings settings = quiet();
    settings.law = laws()[seed % laws().size()];
    if (random.uniform() < 0.7) settings.fidelity.tolerance = powerOf(random, 5e-5, 3e-3);
    if (random.uniform() < 0.3) settings.reuseMotion = 0.02;
    if (random.uniform() < 0.3) settings.bears = 100;
    return settings;
  }
  Random random;
  BulletWorld scene;
};

TEST(FinitePoints, OfRandomWorldsOfAllLaws) {
  const double steps[] = {1. / 60, 1. / 240, 1. / 1000};
  const auto all = laws().size();
  for (std::uint64_t seed = 0; seed < 3 * all; ++seed) {
    SCOPED_TRACE("world " + std::to_string(seed));
    Heap heap(seed);
    expectFinite(heap.scene, steps[seed / all % 3], 50);
  }
}

}  // namespace
}  // namespace cloudcontact::testing::finite_points_test
