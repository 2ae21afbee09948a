// Worlds of five bodies that fall on each other, all else by chance: kinds, masses of 1 to 1,000,
// laws, tolerances, steps, friction and what they fall on. Whatever these are, nothing that is
// infinite or NaN goes to Bullet and no pair fails. On automatic springs no energy comes from
// nowhere; stated ones may be harder than a step can bear (docs/limits.md).
#include <gtest/gtest.h>

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <cloudcontact/bullet/cloud_body.h>
#include <cloudcontact/bullet/diagnosis.h>
#include <cloudcontact/bullet/newton_solver.h>
#include <cloudcontact/field/field_levels.h>

#include <cmath>
#include <initializer_list>

#include "bullet/bullet_world.h"
#include "bullet/solid_meshes.h"
#include "mesh/plain_nut.h"
#include "mesh/turned_mesh.h"

namespace cloudcontact::testing::random_worlds_test {
namespace {

constexpr double kVoxel = 0.004;
constexpr int kBodies = 5, kWorldsAShare = 25;

std::shared_ptr<const FieldLevels> levelsOf(const Mesh& mesh) {
  DigitizeSettings settings;
  settings.voxelSize = kVoxel;
  return std::make_shared<const FieldLevels>(digitize(mesh, settings));
}

// Made once.
const std::vector<std::shared_ptr<const FieldLevels>>& kinds() {
  static const std::vector<std::shared_ptr<const FieldLevels>> all = {
      levelsOf(boxMesh({0.1, 0.08, 0.06})),
      levelsOf(sphereMesh(0.05, 1e-5)),
      levelsOf(test::roundMesh(0.04, 0.1, 64)),
      levelsOf(test::capsuleMesh(0.03, 0.04, 48)),
      levelsOf(coneMesh(0.05, 0.1, 48)),
      levelsOf(angleMesh(0.12, 0.09, 0.025, 0.05)),
      levelsOf(plainNut(0.1, 0.05, 0.04)),
      levelsOf(test::turnedMesh(
          {{0, 0}, {0.05, 0}, {0.065, 0.06}, {0.05, 0.06}, {0.036, 0.016}, {0, 0.016}}, 48))};
  return all;
}

std::optional<Law> anyLaw(Random& random) {
  const double k = std::pow(10, random.uniform(4, 7)), c = std::pow(10, random.uniform(0, 3));
  switch (static_cast<int>(random.uniform(0, 9))) {
    case 0:
      return KelvinVoigt{k, 0};
    case 1:
      return KelvinVoigt{k, c};
    case 2:
      return Foundation{100 * k, 0};
    case 3:
      return Maxwell{k, c};
    case 4:
      return StandardLinearSolid{k, k, c};
    case 5:
      return TableLaw{{{0.001, 0.001 * k}, {0.01, 0.1 * k}}, c};
    default:
      return std::nullopt;  // an automatic spring
  }
}

Fidelity anyFidelity(Random& random) {
  constexpr double kTolerances[] = {0, 0, 0.0003, 0.002, 0.01};
  const int one = static_cast<int>(random.uniform(0, 6));
  if (one == 5) return {.exact = true};
  return {.tolerance = kTolerances[one]};
}

// What all fall on; its surface is at a height of 0.
class Ground {
 public:
  explicit Ground(Random& random) {
    const int kind = static_cast<int>(random.uniform(0, 3));
    btTransform place = btTransform::getIdentity();
    if (kind == 0) {
      shape_ = std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), btScalar(0));
    } else if (kind == 1) {
      shape_ = std::make_unique<btBoxShape>(btVector3(2, 2, btScalar(0.5)));
      place.setOrigin({0, 0, btScalar(-0.5)});
    } else {
      shape_ = std::make_unique<btHeightfieldTerrainShape>(kEdge, kEdge, heights_.data(),
                                                           btScalar(1), btScalar(-1), btScalar(1),
                                                           2, PHY_FLOAT, false);
      shape_->setLocalScaling({btScalar(0.2), btScalar(0.2), 1});
    }
    body = std::make_unique<btRigidBody>(
        btRigidBody::btRigidBodyConstructionInfo(0, nullptr, shape_.get()));
    body->setWorldTransform(place);
  }
  std::unique_ptr<btRigidBody> body;

 private:
  static constexpr int kEdge = 24;
  std::vector<float> heights_ = std::vector<float>(kEdge * kEdge, 0.0f);
  std::unique_ptr<btCollisionShape> shape_;
};

CloudContactSettings settingsOf(Random& random) {
  CloudContactSettings settings;
  settings.law = anyLaw(random);
  settings.bears = 100;
  return settings;
}

class RandomWorld {
 public:
  explicit RandomWorld(Random& random)
      : clouds_(settingsOf(random)), ground_(random), step_(stepOf(random)) {
    clouds_.attach(dispatcher_);
    recommendedSettings(world_);
    world_.setGravity({0, 0, btScalar(-9.81)});
    ground_.body->setFriction(1);
    world_.addRigidBody(ground_.body.get());
    const double friction = random.uniform();
    const Fidelity fidelity = anyFidelity(random);
    for (int i = 0; i < kBodies; ++i) {
      const auto& kind =
          kinds()[static_cast<std::size_t>(random.uniform(0, double(kinds().size())))];
      const Eigen::Quaterniond q = random.rotation();
      const btTransform place(
          btQuaternion(btScalar(q.x()), btScalar(q.y()), btScalar(q.z()), btScalar(q.w())),
          {btScalar(random.uniform(-0.05, 0.05)), btScalar(random.uniform(-0.05, 0.05)),
           btScalar(0.15 + 0.26 * i)});
      CloudBodySettings settings;
      settings.mass = std::pow(10, random.uniform(-1.5, 1.5));
      settings.fidelity = fidelity;
      bodies_.emplace_back(kind, place, settings);
      bodies_.back().body().setFriction(btScalar(friction));
      bodies_.back().addTo(world_);
    }
  }
  ~RandomWorld() { world_.removeRigidBody(ground_.body.get()); }

  double step() {
    world_.stepSimulation(btScalar(step_), 0);
    return step_;
  }

  double energy() const {  // [J]
    double sum = 0;
    for (const CloudBody& one : bodies_) {
      const btRigidBody& body = one.body();
      const btVector3 spin =
          body.getWorldTransform().getBasis().transpose() * body.getAngularVelocity();
      const btVector3 inertia = body.getLocalInertia();
      sum += double(body.getMass()) * (0.5 * double(body.getLinearVelocity().length2()) +
                                       9.81 * double(body.getCenterOfMassPosition().z()));
      for (int k = 0; k < 3; ++k)
        sum += 0.5 * double(inertia[k]) * double(spin[k]) * double(spin[k]);
    }
    return sum;
  }

  bool isFinite() const {
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      btPersistentManifold& manifold =
          *const_cast<btCollisionDispatcher&>(dispatcher_).getManifoldByIndexInternal(i);
      for (int j = 0; j < manifold.getNumContacts(); ++j)
        if (!isFinite(manifold.getContactPoint(j))) return false;
    }
    return std::isfinite(energy());
  }

  bool isAutomatic() const { return !clouds_.settings().law; }
  std::size_t failures() const { return clouds_.statistics().failures; }

 private:
  static double stepOf(Random& random) {
    constexpr double kRates[] = {60, 100, 120, 240, 480};
    return 1 / kRates[static_cast<int>(random.uniform(0, 5))];
  }

  static bool isFinite(const btManifoldPoint& p) {
    for (const btVector3& v :
         {p.m_localPointA, p.m_localPointB, p.m_positionWorldOnA, p.m_positionWorldOnB,
          p.m_normalWorldOnB, p.m_lateralFrictionDir1, p.m_lateralFrictionDir2})
      if (!std::isfinite(v.length2())) return false;
    for (const btScalar x :
         {p.m_distance1, p.m_combinedFriction, p.m_combinedRestitution, p.m_appliedImpulse,
          p.m_appliedImpulseLateral1, p.m_appliedImpulseLateral2, p.m_contactMotion1,
          p.m_contactMotion2, p.m_combinedContactStiffness1, p.m_combinedContactDamping1})
      if (!std::isfinite(x)) return false;
    return true;
  }

  CloudContact clouds_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  NewtonSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  Ground ground_;
  std::vector<CloudBody> bodies_;
  double step_;
};

void run(std::uint64_t seed) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  RandomWorld world(random);
  const double start = world.energy();
  for (double time = 0; time < 1; time += world.step()) {
    ASSERT_TRUE(world.isFinite()) << "after " << time << " s";
    if (!world.isAutomatic()) continue;
    ASSERT_LE(world.energy(), start * 1.0005) << "after " << time << " s";
  }
  EXPECT_EQ(world.failures(), 0u);
}

class RandomWorlds : public ::testing::TestWithParam<int> {};

TEST_P(RandomWorlds, MakeNoEnergyAndNothingInfinite) {
  for (int i = 0; i < kWorldsAShare; ++i)
    run(static_cast<std::uint64_t>(GetParam() * kWorldsAShare + i));
}

INSTANTIATE_TEST_SUITE_P(Some, RandomWorlds, ::testing::Range(0, 8));
INSTANTIATE_TEST_SUITE_P(Many, RandomWorlds, ::testing::Range(8, 400));

}  // namespace
}  // namespace cloudcontact::testing::random_worlds_test
