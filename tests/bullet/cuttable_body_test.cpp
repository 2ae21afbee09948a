// Bodies that are cut while they move, spin and rest: matter keeps its place and motion, mass and
// momentum are conserved, and contacts persist.
#include <cloudcontact/bullet/cuttable_body.h>
#include <gtest/gtest.h>

#include <map>
#include <stdexcept>

#include "bullet/bullet_world.h"
#include "workpiece/cut_cases.h"

namespace cloudcontact::testing::cuttable_body_test {
namespace {

constexpr double kVoxel = 2e-3;
constexpr double kKept = sizeof(btScalar) == 4 ? 1e-5 : 1e-9;

btVector3 v(double x, double y, double z) {
  return {btScalar(x), btScalar(y), btScalar(z)};
}
Vec3 vec(const btVector3& a) {
  return {a.x(), a.y(), a.z()};
}

CuttableBodySettings plain() {
  CuttableBodySettings settings;
  settings.threads = 1;
  return settings;
}

const Cloud& toothCloud() {
  static const Cloud cloud = cloudOf(tooth({20, 20, 22}), {5, 5, 5}, kVoxel);
  return cloud;
}
const Cloud& boxCloud() {
  static const Cloud cloud = cloudOf(
      [](const Vec3& p) {
        return ((p - Vec3(16.25, 16, 12)).cwiseAbs().array() < Vec3(12, 8, 8).array()).all();
      },
      {4, 4, 3}, kVoxel);
  return cloud;
}

struct Scene {
  BulletWorld world;
  std::unique_ptr<CuttableBody> body;

  explicit Scene(const Cloud& cloud, const CuttableBodySettings& settings = plain())
      : body(std::make_unique<CuttableBody>(
            cloud,
            btTransform(btQuaternion(v(1, 2, 3).normalized(), btScalar(0.7)), v(0.3, -0.2, 0.5)),
            settings)) {
    body->addTo(world.world);
    body->body().setLinearVelocity(v(0.7, -1.1, 0.4));
    body->body().setAngularVelocity(v(3, -5, 8));
  }
  ~Scene() { body.reset(); }
};

void add(MovingMatter& sum, const MovingMatter& more) {
  sum.mass += more.mass;
  sum.momentum += more.momentum;
  sum.angularMomentum += more.angularMomentum;
}

// Position and velocity of some voxels in the world.
struct Marks {
  std::vector<Vec3> place, velocity;

  explicit Marks(const CuttableBody& body) {
    const btTransform at = body.cloudPlace();
    const Cloud& cloud = body.cloud();
    for (const Eigen::Vector3i& voxel :
         {Eigen::Vector3i(0, 0, 0), Eigen::Vector3i(20, 11, 13), Eigen::Vector3i(31, 2, 7)}) {
      const Vec3 local = cloud.center(voxel.x(), voxel.y(), voxel.z());
      const btVector3 world = at * v(local.x(), local.y(), local.z());
      place.push_back(vec(world));
      velocity.push_back(
          vec(body.body().getVelocityInLocalPoint(world - body.body().getCenterOfMassPosition())));
    }
  }
};

void expectSameMotion(const Marks& a, const Marks& b) {
  for (std::size_t k = 0; k < a.place.size(); ++k) {
    EXPECT_LT((a.place[k] - b.place[k]).norm(), 0.1 * kKept) << k;
    EXPECT_LT((a.velocity[k] - b.velocity[k]).norm(), kKept * 2) << k;
  }
}

// Mass and momentum of bodies and cut-away matter together, against those before the cut.
void expectKept(const MovingMatter& before, const CuttableBody& body, const CutOutcome& outcome) {
  MovingMatter after = outcome.cutAway;
  if (!outcome.gone) add(after, body.matter());
  for (const auto& piece : outcome.fallen) add(after, piece->matter());
  EXPECT_NEAR(after.mass, before.mass, kKept * before.mass);
  EXPECT_LT((after.momentum - before.momentum).norm(), kKept * before.momentum.norm());
  EXPECT_LT((after.angularMomentum - before.angularMomentum).norm(),
            kKept * before.angularMomentum.norm());
}

TEST(CuttableBody, IsTheMatterItIsMadeOf) {
  Scene scene(boxCloud());
  const double mass = 1000 * 24 * 16 * 16 * std::pow(kVoxel, 3);
  EXPECT_NEAR(1 / scene.body->body().getInvMass(), mass, 1e-3 * mass);
  const Vec3 middle = boxCloud().origin() + kVoxel * Vec3(16.25, 16, 12);
  const btVector3 wanted = scene.body->cloudPlace() * v(middle.x(), middle.y(), middle.z());
  EXPECT_LT((scene.body->body().getCenterOfMassPosition() - wanted).length(), 0.02 * kVoxel);
}

TEST(CuttableBody, ABiteLeavesTheRestAsItMoved) {
  Scene scene(toothCloud());
  Random random(3);
  for (int k = 0; k < 3; ++k) {
    const MovingMatter before = scene.body->matter();
    const Marks marks(*scene.body);
    const btVector3 center = scene.body->body().getCenterOfMassPosition();
    const Cloud& cloud = scene.body->cloud();
    const CutOutcome outcome =
        scene.body->cut(bite(cloud, Vec3(24 + 4 * k, 20, 30), random.uniform(4, 7)));
    EXPECT_TRUE(outcome.fallen.empty());
    EXPECT_GT(outcome.cutAway.mass, 0.003 * before.mass);
    EXPECT_GT((scene.body->body().getCenterOfMassPosition() - center).length(), 0.02 * kVoxel);
    expectKept(before, *scene.body, outcome);
    expectSameMotion(marks, Marks(*scene.body));
    scene.world.step(1 / 240.0);
  }
}

TEST(CuttableBody, FallsApartWhereItIsCutThrough) {
  Scene scene(toothCloud());
  const MovingMatter before = scene.body->matter();
  const Marks marks(*scene.body);
  const CutOutcome outcome = scene.body->cut(sawn(scene.body->cloud(), 24.3, 26.8));
  ASSERT_EQ(outcome.fallen.size(), 1u);
  CuttableBody& piece = *outcome.fallen[0];
  expectKept(before, *scene.body, outcome);
  expectSameMotion(marks, Marks(*scene.body));
  expectSameMotion(marks, Marks(piece));
  EXPECT_GT(scene.body->matter().mass, piece.matter().mass) << "the heaviest is the body";
  EXPECT_EQ(scene.world.world.getNumCollisionObjects(), 2);
  // They spin apart without contact in the saw's kerf.
  const double apart = (scene.body->matter().center - piece.matter().center).norm();
  for (int k = 0; k < 20; ++k) scene.world.step(1 / 240.0);
  EXPECT_GT((scene.body->matter().center - piece.matter().center).norm(), 1.01 * apart);
}

TEST(CuttableBody, FallsInSeveralPieces) {
  Scene scene(boxCloud());
  const MovingMatter before = scene.body->matter();
  std::vector<VoxelCut> cuts = sawn(scene.body->cloud(), 11, 12);
  const std::vector<VoxelCut> more = sawn(scene.body->cloud(), 20, 22);
  cuts.insert(cuts.end(), more.begin(), more.end());
  const CutOutcome outcome = scene.body->cut(cuts);
  EXPECT_EQ(outcome.fallen.size(), 2u);
  expectKept(before, *scene.body, outcome);
}

TEST(CuttableBody, CrumbsCountAsCutAway) {
  CuttableBodySettings settings = plain();
  settings.leastPiece = 1000 * 5 * 256 * std::pow(kVoxel, 3);  // five layers of the box
  Scene scene(boxCloud(), settings);
  const MovingMatter before = scene.body->matter();
  const CutOutcome outcome = scene.body->cut(sawn(scene.body->cloud(), 8, 9));
  EXPECT_TRUE(outcome.fallen.empty());
  EXPECT_NEAR(outcome.cutAway.mass, 1000 * 4.75 * 256 * std::pow(kVoxel, 3), 1e-3 * before.mass);
  expectKept(before, *scene.body, outcome);
}

TEST(CuttableBody, IsGoneWhenAllIsCut) {
  Scene scene(boxCloud());
  const MovingMatter before = scene.body->matter();
  const CutOutcome outcome = scene.body->cut(sawn(scene.body->cloud(), 0, 32));
  EXPECT_TRUE(outcome.gone);
  EXPECT_EQ(scene.world.world.getNumCollisionObjects(), 0);
  EXPECT_EQ(scene.body->matter().mass, 0);
  expectKept(before, *scene.body, outcome);
}

TEST(CuttableBody, WeighsItsMaterials) {
  auto voxels = std::make_shared<Cloud::Voxels>(boxCloud().voxels());
  voxels->materials = {"light", "heavy"};
  for (std::size_t t = 0; t < voxels->table.size(); ++t)
    voxels->materialTable.push_back(t % 4 < 2 ? -1 : -2);
  CuttableBodySettings settings = plain();
  settings.densities = {1000, 3000};
  Scene scene(Cloud(kVoxel, boxCloud().origin(), voxels), settings);
  const double layer = 256 * std::pow(kVoxel, 3);
  const MovingMatter before = scene.body->matter();
  EXPECT_NEAR(before.mass, layer * (1000 * 11.75 + 3000 * 12.25), 2e-3 * before.mass);
  const CutOutcome outcome = scene.body->cut(sawn(scene.body->cloud(), 15, 17));
  EXPECT_NEAR(outcome.cutAway.mass, layer * 4000, 1e-3 * before.mass);
  ASSERT_EQ(outcome.fallen.size(), 1u);
  EXPECT_EQ(outcome.fallen[0]->cloud().coverage(10, 16, 12), 255) << "the light end falls off";
  expectKept(before, *scene.body, outcome);
}

std::map<int, double> impulses(const BulletWorld& world) {
  std::map<int, double> all;
  for (const btManifoldPoint& point : world.points())
    all[point.m_partId0] = double(point.m_appliedImpulse);
  return all;
}

// A box at rest on the ground keeps its contacts' IDs and the solver's data when its top is cut,
// and does not move.
TEST(CuttableBody, RestsOnWhenItsTopIsCut) {
  BulletWorld world;
  world.addGround();
  CuttableBody body(boxCloud(), at(-v(0.1, -0.2, 0.05) - v(0, 0, 4 * kVoxel)), plain());
  body.addTo(world.world);
  body.body().setActivationState(DISABLE_DEACTIVATION);
  for (int k = 0; k < 240; ++k) world.step(1 / 240.0);
  const auto before = impulses(world);
  ASSERT_GE(before.size(), 4u);
  const Marks marks(body);
  const MovingMatter whole = body.matter();
  std::vector<VoxelCut> cuts = cutsOf(
      body.cloud(), [](const Vec3& p) { return p.z() > 15 && p.x() > 15; }, Vec3(14, 0, 14),
      Vec3(32, 32, 24));
  const CutOutcome outcome = body.cut(cuts);
  EXPECT_GT(outcome.cutAway.mass, 0.15 * whole.mass);
  EXPECT_GT(outcome.frame.position.norm(), kVoxel) << "the frame must have moved for this to test";
  world.step(1 / 240.0);
  const auto after = impulses(world);
  ASSERT_EQ(after.size(), before.size());
  for (const auto& [id, impulse] : before) {
    ASSERT_TRUE(after.count(id)) << id;
    EXPECT_GT(after.at(id), 0.3 * impulse) << id;
  }
  for (int k = 0; k < 240; ++k) world.step(1 / 240.0);
  const Marks later(body);
  for (std::size_t k = 0; k < marks.place.size(); ++k)
    EXPECT_LT((later.place[k] - marks.place[k]).norm(), 0.2 * kVoxel);
  EXPECT_LT(vec(body.body().getLinearVelocity()).norm(), 1e-3);
  double carried = 0;
  for (const auto& [id, impulse] : impulses(world)) carried += impulse;
  EXPECT_NEAR(carried, body.matter().mass * 9.81 / 240, 0.02 * carried);
}

// Removed material has no contact.
TEST(CuttableBody, IsNotFeltWhereItWasCut) {
  BulletWorld world;
  world.world.setGravity(v(0, 0, 0));
  CuttableBody body(boxCloud(), at(v(0, 0, 0)), plain());
  body.addTo(world.world);
  const Vec3 top = boxCloud().origin() + kVoxel * Vec3(22, 16, 20);
  world.add(std::make_unique<btSphereShape>(btScalar(3 * kVoxel)), 0,
            at(v(top.x(), top.y(), top.z() + 2 * kVoxel)));
  world.detect();
  EXPECT_FALSE(world.points().empty());
  body.cut(bite(body.cloud(), Vec3(22, 16, 20), 7));
  world.detect();
  EXPECT_TRUE(world.points().empty());
}

TEST(CuttableBody, RefusesAnythingButACut) {
  Scene scene(boxCloud());
  const Cloud whole = scene.body->cloud();
  const CutOutcome outcome = scene.body->cut(bite(whole, Vec3(16, 16, 20), 4));
  const MovingMatter before = scene.body->matter();
  EXPECT_THROW(scene.body->become(whole), std::invalid_argument);
  EXPECT_THROW(scene.body->become(whole.translated(Vec3(1, 0, 0))), std::invalid_argument);
  EXPECT_THROW(scene.body->become(toothCloud()), std::invalid_argument);
  const VoxelCut outside{{99, 0, 0}, 0};
  EXPECT_THROW(scene.body->cut({&outside, 1}), std::out_of_range);
  EXPECT_EQ(scene.body->matter().mass, before.mass);
  CuttableBodySettings settings = plain();
  settings.densities = {1, 2, 3};
  EXPECT_THROW(CuttableBody(whole, at(v(0, 0, 0)), settings), std::invalid_argument);
  settings.densities = {0};
  EXPECT_THROW(CuttableBody(whole, at(v(0, 0, 0)), settings), std::invalid_argument);
  EXPECT_THROW(CuttableBody(Cloud(), at(v(0, 0, 0))), std::invalid_argument);
}

// A law, a viscoelastic one too, holds for every piece, as do friction and the world's step.
TEST(CuttableBody, PiecesKeepTheLaw) {
  for (const Law& law :
       {Law(KelvinVoigt{3e4, 20}), Law(Maxwell{2e4, 50}), Law(StandardLinearSolid{1e4, 2e4, 30})}) {
    CuttableBodySettings settings = plain();
    settings.law = law;
    Scene scene(boxCloud(), settings);
    const Marks marks(*scene.body);
    const CutOutcome outcome = scene.body->cut(sawn(scene.body->cloud(), 11, 12));
    ASSERT_EQ(outcome.fallen.size(), 1u);
    CuttableBody& piece = *outcome.fallen[0];
    expectSameMotion(marks, Marks(piece));
    for (const CloudShape* shape : {&scene.body->shape(), &piece.shape()}) {
      ASSERT_TRUE(shape->law);
      ASSERT_EQ(shape->law->index(), law.index());
      LawState a, b;
      for (const double depth : {1e-4, 2e-4, 1e-4}) {
        a = lawAdvance(law, a, depth, 1e-3);
        b = lawAdvance(*shape->law, b, depth, 1e-3);
        EXPECT_EQ(a.branchForce, b.branchForce);
      }
    }
  }
}

// The edges of a cut are found in the steps that follow, in the same order each time.
TEST(CuttableBody, SettlesInTheStepsAfterACut) {
  std::size_t steps[2] = {};
  for (std::size_t& count : steps) {
    Scene scene(boxCloud());
    CuttableBody& body = *scene.body;
    for (int k = 0; k < 4; ++k) {
      body.cut(bite(body.cloud(), Vec3(12 + k, 16, 20), 5));
      scene.world.step(1 / 240.0);
    }
    ASSERT_GT(body.shape().field().unsettled(), 0u);
    FieldSettings how;
    how.threads = 1;
    const std::uint64_t wanted = SurfaceField::build(body.cloud(), how)->hash();
    EXPECT_NE(body.shape().field().hash(), wanted) << "the test must wait for something";
    for (; body.shape().field().unsettled() > 0 && count < 2000; ++count)
      scene.world.step(1 / 240.0);
    EXPECT_EQ(body.shape().field().hash(), wanted);
  }
  EXPECT_GT(steps[0], 2u);
  EXPECT_EQ(steps[0], steps[1]);
}

TEST(CuttableBody, SettlesAtOnceWhenAsked) {
  Scene scene(toothCloud());
  CuttableBody& body = *scene.body;
  body.cut(bite(body.cloud(), Vec3(20, 20, 32), 6));
  ASSERT_GT(body.shape().field().unsettled(), 0u);
  body.settle();
  FieldSettings how;
  how.threads = 1;
  EXPECT_EQ(body.shape().field().hash(), SurfaceField::build(body.cloud(), how)->hash());
}

// Others may hold the field: a cut makes a new one.
TEST(CuttableBody, LeavesSharedFieldsAlone) {
  Scene scene(boxCloud());
  CloudShape other = scene.body->shape();
  const std::uint64_t before = other.field().hash();
  scene.body->cut(bite(boxCloud(), Vec3(16, 16, 20), 5));
  scene.world.step(1 / 240.0);
  EXPECT_EQ(other.field().hash(), before);
  EXPECT_NE(scene.body->shape().field().hash(), before);
}

// A bur that bites into the tooth until it falls apart, and a saw.
std::vector<VoxelCut> cutOfStep(const Cloud& cloud, int step) {
  if (step == 12) return sawn(cloud, 19, 20.5);
  return step < 12 ? bite(cloud, Vec3(12 + step, 20, 31), 4) : std::vector<VoxelCut>();
}

// Cuts gradually in running steps. Nothing is lost on the way, and in the end all is as if it had
// been cut at once.
TEST(CuttableBody, GradualCutsEndWhereCutsAtOnceDo) {
  Scene gradual(toothCloud()), atOnce(toothCloud());
  std::vector<std::unique_ptr<CuttableBody>> fallen, expected;
  int steps = 0, behind = 0;
  for (; steps < 13 || gradual.body->behind(); ++steps) {
    ASSERT_LT(steps, 100);
    const std::vector<VoxelCut> cuts = cutOfStep(atOnce.body->cloud(), steps);
    const MovingMatter before = gradual.body->matter();
    CutOutcome outcome = cuts.empty() ? gradual.body->goOn() : gradual.body->cutGradually(cuts);
    expectKept(before, *gradual.body, outcome);
    for (auto& piece : outcome.fallen) fallen.push_back(std::move(piece));
    for (auto& piece : atOnce.body->cut(cuts).fallen) expected.push_back(std::move(piece));
    behind += gradual.body->behind();
    gradual.world.step(1 / 1000.0);
    atOnce.world.step(1 / 1000.0);
  }
  EXPECT_GT(behind, 1);
  ASSERT_EQ(fallen.size(), expected.size());
  ASSERT_FALSE(fallen.empty());
  const auto expectSame = [](CuttableBody& a, CuttableBody& b) {
    EXPECT_EQ(a.volume(), b.volume());
    EXPECT_TRUE(a.settle().fallen.empty());
    b.settle();
    EXPECT_EQ(a.shape().field().hash(), b.shape().field().hash());
    EXPECT_EQ(a.shape().field().hash(), SurfaceField::build(a.cloud())->hash());
    EXPECT_LT((vec(a.cloudPlace().getOrigin()) - vec(b.cloudPlace().getOrigin())).norm(),
              0.2 * kVoxel);  // the pieces turn about their own centers a few steps later
  };
  expectSame(*gradual.body, *atOnce.body);
  for (std::size_t k = 0; k < fallen.size(); ++k) expectSame(*fallen[k], *expected[k]);
}

// Cuts go on while a piece is falling off: they count for the body and for the piece.
TEST(CuttableBody, IsCutOnWhilePiecesFall) {
  Scene scene(toothCloud());
  std::vector<VoxelCut> more = bite(toothCloud(), Vec3(11, 20, 26), 5);
  const std::vector<VoxelCut> right = bite(toothCloud(), Vec3(29, 20, 26), 5);
  more.insert(more.end(), right.begin(), right.end());
  const Cloud wanted = cutCloud(cutCloud(toothCloud(), sawn(toothCloud(), 19, 20.5)), more);
  EXPECT_TRUE(scene.body->cutGradually(sawn(toothCloud(), 19, 20.5)).fallen.empty());
  const MovingMatter before = scene.body->matter();
  CutOutcome outcome = scene.body->cutGradually(more);
  const CutOutcome rest = scene.body->settle();
  outcome.cutAway.mass += rest.cutAway.mass;
  EXPECT_TRUE(outcome.fallen.empty());
  ASSERT_EQ(rest.fallen.size(), 1u);
  CuttableBody& piece = *rest.fallen[0];
  EXPECT_TRUE(piece.behind());
  EXPECT_NEAR(outcome.cutAway.mass + scene.body->matter().mass + piece.matter().mass, before.mass,
              kKept * before.mass);
  while (piece.behind()) scene.world.step(1 / 1000.0);  // the world's steps do the work, too
  const auto same = [&](const Cloud& a, int x, int y, int z) {
    return a.coverage(x, y, z) == wanted.coverage(x, y, z);
  };
  for (int x = 0; x < 40; ++x)
    for (int y = 0; y < 40; ++y)
      for (int z = 0; z < 40; ++z) {
        const bool ofPiece = piece.cloud().coverage(x, y, z) > 0;
        EXPECT_TRUE(same(ofPiece ? piece.cloud() : scene.body->cloud(), x, y, z));
      }
  EXPECT_EQ(piece.shape().field().cloud().coverage(29, 20, 26), 0);
}

TEST(CuttableBody, GradualCutsRepeatOnAnyNumberOfThreads) {
  const auto run = [](int threads) {
    CuttableBodySettings settings = plain();
    settings.threads = threads;
    Scene scene(toothCloud(), settings);
    std::vector<std::uint64_t> hashes;
    std::vector<std::unique_ptr<CuttableBody>> fallen;
    for (int k = 0; k < 30; ++k) {
      CutOutcome outcome = scene.body->cutGradually(cutOfStep(scene.body->cloud(), k));
      for (auto& piece : outcome.fallen) fallen.push_back(std::move(piece));
      hashes.push_back(scene.body->shape().field().hash());
      scene.world.step(1 / 1000.0);
    }
    hashes.push_back(fallen.size());
    return hashes;
  };
  const auto one = run(1);
  EXPECT_EQ(one, run(2));
  EXPECT_EQ(one, run(5));
}

TEST(CuttableBody, IsGoneWhenAllIsCutGradually) {
  Scene scene(boxCloud());
  const MovingMatter before = scene.body->matter();
  scene.body->cutGradually(bite(boxCloud(), Vec3(10, 16, 12), 6));
  const double bitten = before.mass - scene.body->matter().mass;
  EXPECT_GT(bitten, 0);
  const CutOutcome outcome = scene.body->cutGradually(sawn(boxCloud(), 0, 32));
  EXPECT_TRUE(outcome.gone);
  EXPECT_FALSE(scene.body->behind());
  EXPECT_NEAR(outcome.cutAway.mass, before.mass - bitten, kKept * before.mass);
  EXPECT_EQ(scene.body->volume(), 0);
  EXPECT_EQ(scene.body->world(), nullptr);
}

// States the window that is used where none is stated.
void useWindow(CloudShape& shape) {
  PaperSettings paper;
  paper.window = sphereWindow(shape.cloud().voxelSize());
  shape.usePaper(paper);
}

// The base vectors of the paper's method follow cuts: the same as those made from the cloud.
TEST(CuttableBody, BaseVectorsFollowCuts) {
  Scene scene(toothCloud());
  const auto hashOf = [](const Cloud& cloud) { return paperBody(cloud, {}).vectors->hash(); };
  useWindow(scene.body->shape());
  const auto held = scene.body->shape().paper();
  const std::uint64_t first = held->vectors->hash();
  for (int k = 0; k < 4; ++k) {
    scene.body->cut(cutOfStep(scene.body->cloud(), k));
    if (k == 1) continue;  // two cuts between two queries
    EXPECT_EQ(scene.body->shape().paper()->vectors->hash(), hashOf(scene.body->cloud())) << k;
  }
  EXPECT_EQ(held->vectors->hash(), first);
}

TEST(CuttableBody, WithoutACutNothingChanges) {
  Scene scene(boxCloud());
  const btTransform before = scene.body->body().getWorldTransform();
  const CutOutcome outcome = scene.body->cut({});
  EXPECT_EQ(outcome.cutAway.mass, 0);
  EXPECT_TRUE(scene.body->body().getWorldTransform() == before);
}

// Pieces have the body's tissues, and base vectors as if made from their own clouds.
TEST(CuttableBody, PiecesKeepTissuesAndBaseVectors) {
  Scene scene(toothCloud());
  const TissueTable wax = {{"wax", 3e4, 40, 1e6, 900}};
  scene.body->shape().setTissues(wax);
  useWindow(scene.body->shape());
  const CutOutcome outcome = scene.body->cut(sawn(toothCloud(), 19, 20.5));
  ASSERT_EQ(outcome.fallen.size(), 1u);
  for (CuttableBody* const body : {scene.body.get(), outcome.fallen[0].get()}) {
    EXPECT_EQ(body->shape().tissues(), wax);
    ASSERT_TRUE(body->shape().usesPaper());
    EXPECT_EQ(body->shape().paper()->vectors->hash(),
              paperBody(body->cloud(), wax).vectors->hash());
  }
}

}  // namespace
}  // namespace cloudcontact::testing::cuttable_body_test
