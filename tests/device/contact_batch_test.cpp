// A batch gives the same bits as a ContactFinder for each pair, on the CPU and through OpenCL.
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/device/contact_batch.h>
#include <cloudcontact/voxels/digitize.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "contact/contact_cases.h"
#include "contact/same_contact.h"
#include "device/skip_without_device.h"
#include "law/hulls.h"
#include "mesh/thread_meshes.h"
#include "mesh/turned_mesh.h"

namespace cloudcontact::testing::contact_batch_test {
namespace {

Mesh torusMesh(double ring, double tube) {
  return revolvedMesh(96, 48, true, [=](double u, double s) {
    const double v = 2 * std::numbers::pi * s, r = ring + tube * std::cos(v);
    return Vec3(r * std::cos(u), r * std::sin(u), tube * std::sin(v));
  });
}

// Bodies of several shapes, in pairs with random poses: apart, grazing, deep.
struct Pairs {
  BodyMaker maker{5e-4, Random(11)};
  std::vector<Body> bodies;
  std::vector<double> sizes;
  std::vector<BatchPair> pairs;

  void add(Body body, double size) {
    bodies.push_back(std::move(body));
    sizes.push_back(size);
  }

  Pairs() {
    const double v = maker.voxel;
    add(maker.sphere(12), 12 * v);
    add(maker.box(Vec3(20, 14, 9)), 10 * v);
    add(maker.box(Vec3(16, 16, 16), true), 10 * v);
    add(maker.cylinder(8, 22), 10 * v);
    add(maker.cloud(torusMesh(14 * v, 6 * v)), 14 * v);
    for (int k = 0; k < 60; ++k) {
      const std::size_t i = std::size_t(k) % bodies.size(), j = std::size_t(k) / 5 % bodies.size();
      Pose pose;
      pose.orientation = maker.random.rotation();
      const double far = (sizes[i] + sizes[j]) * maker.random.uniform(0.2, 1.1);
      pose.position = far * (maker.random.rotation() * Vec3::UnitX());
      BatchPair pair{bodies[i].at({}), bodies[j].at(pose), {}};
      if (k % 4 == 1) pair.settings.samples = 3000;
      if (k % 7 == 2) pair.settings.law = Foundation{1e4, 0};
      if (k % 9 == 4) pair.settings.margin = 1.5 * v;
      pairs.push_back(pair);
    }
    addThreads();
    addTips();
    addTurnedBoxes();
  }

  // Boxes on a box, turned by a degree: samples beyond their edges stand across their sides.
  void addTurnedBoxes() {
    const double v = maker.voxel;
    add(maker.box(Vec3(12, 12, 6)), 8 * v);
    for (const double gap : {0.02, -0.02, -0.2}) {
      Pose pose;
      pose.position = Vec3(3.3, 0.4, 12 + gap) * v;
      pose.orientation = Eigen::AngleAxisd(std::numbers::pi / 180, Vec3::UnitZ());
      pairs.push_back({bodies.back().at({}), bodies.back().at(pose), {}});
    }
  }

  // Cones tip in tip on one axis, where no surface faces another.
  void addTips() {
    const double v = maker.voxel;
    add(maker.cloud(test::turnedMesh({{0, 0}, {6 * v, 0}, {0, 40 * v}}, 48)), 20 * v);
    for (const double deep : {0.5, 2.0, 5.0}) {
      Pose pose;
      pose.position = Vec3(0, 0, (80 - deep) * v);
      pose.orientation = Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX());
      pairs.push_back({bodies.back().at({}), bodies.back().at(pose), {}});
    }
  }

  // A ring on a threaded rod, 0.3 voxels too tight, slightly turned and shifted.
  void addThreads() {
    const double v = maker.voxel;
    const Thread thread{16 * v, 8 * v, 4.4 * v};
    add(maker.cloud(threadedRod(thread, 40 * v)), 20 * v);
    add(maker.cloud(threadedRing(thread, 20 * v, 26 * v, -0.3 * v)), 26 * v);
    const Body &rod = bodies[bodies.size() - 2], &ring = bodies.back();
    for (int k = 0; k < 6; ++k) {
      Pose pose;
      pose.position = 0.5 * v * maker.random.inCube();
      pose.orientation = Eigen::Quaterniond(1, 0.01 * maker.random.uniform(), 0.01, 0.01 * k);
      pose.orientation.normalize();
      pairs.push_back({rod.at({}), ring.at(pose), {}});
      if (k % 2) pairs.back().settings.samples = 5000;
    }
  }
};

const Pairs& all() {
  static const Pairs pairs;
  return pairs;
}

void equalToFinder(ContactBatch& batch, int times) {
  const std::vector<BatchPair>& pairs = all().pairs;
  std::vector<ContactFinder> finders(pairs.size());
  std::size_t touching = 0;
  for (int time = 0; time < times; ++time) {
    const auto results = batch.find(pairs);
    ASSERT_EQ(results.size(), pairs.size());
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      SCOPED_TRACE("pair " + std::to_string(k));
      const ContactResult& want = finders[k].find(pairs[k].a, pairs[k].b, pairs[k].settings);
      expectSame(*results[k], want);
      touching += !want.patches.empty();
    }
  }
  EXPECT_GT(touching, pairs.size() / 3);
}

TEST(Batch, CpuEqualsTheFinder) {
  ContactBatch batch({Backend::Cpu, 2});
  EXPECT_EQ(batch.backend(), Backend::Cpu);
  equalToFinder(batch, 2);
}

TEST(Batch, DeviceEqualsTheFinder) {
  ContactBatch batch({Backend::OpenCl, 2});
  SKIP_WITHOUT(batch);
  equalToFinder(batch, 3);
  EXPECT_GT(batch.report().onDevice, all().pairs.size() / 2);
}

TEST(Batch, PairsWithoutRoomRunOnTheCpuOnce) {
  ContactBatch batch({Backend::OpenCl, 1, false});
  SKIP_WITHOUT(batch);
  BodyMaker maker{5e-4, Random(5)};
  const Body slab = maker.box(Vec3(64, 64, 8), true);
  Pose pose;
  pose.position = Vec3(0, 0, 7.5 * maker.voxel);
  BatchPair pair{slab.at({}), slab.at(pose), {}};
  pair.settings.law = Foundation{1e4, 0};  // uses all samples: more than 4,000 a side
  ContactFinder finder;
  for (int time = 0; time < 2; ++time) {
    const auto results = batch.find({&pair, 1});
    expectSame(*results[0], finder.find(pair.a, pair.b, pair.settings));
    EXPECT_GT(results[0]->samples, 4096u);
    EXPECT_EQ(batch.report().noRoom, time == 0 ? 1u : 0u);
    EXPECT_EQ(batch.report().onDevice, time == 0 ? 0u : 1u);
  }
}

// More patches than fit at first: 49 pegs on a plate, in 64 pairs a part.
TEST(Batch, PairsWithManyPatchesRunOnTheCpuUntilTheyFit) {
  ContactBatch batch({Backend::OpenCl, 2, false});
  SKIP_WITHOUT(batch);
  BodyMaker maker{5e-4, Random(3)};
  const double v = maker.voxel;
  Mesh pegs;
  for (int k = 0; k < 49; ++k) {
    const Mesh peg =
        transformed(boxMesh(Vec3(5, 5, 6) * v),
                    {Eigen::Quaterniond::Identity(), Vec3(k % 7 - 3, k / 7 - 3, 0) * 26 * v});
    const int first = static_cast<int>(pegs.vertices.size());
    pegs.vertices.insert(pegs.vertices.end(), peg.vertices.begin(), peg.vertices.end());
    for (const auto& t : peg.triangles)
      pegs.triangles.push_back(t + Eigen::Vector3i::Constant(first));
  }
  const Body top = maker.cloud(pegs, true), plate = maker.box(Vec3(170, 170, 8), true);
  Pose pose;
  pose.position = Vec3(0, 0, 6.6 * v);
  BatchPair pair{plate.at({}), top.at(pose), {}};
  pair.settings.samples = 100000;  // with fine samples each peg is a patch of its own
  const std::vector<BatchPair> few(2, pair), many(128, pair);
  ContactFinder finder;
  const ContactResult& want = finder.find(few[0].a, few[0].b, few[0].settings);
  EXPECT_EQ(want.patches.size(), 49u);
  // At first the hits do not fit, then the bins, then the patches.
  for (const std::vector<BatchPair>& pairs : {few, many}) {
    std::size_t least = pairs.size(), noRoom = least;
    bool forSome = false;
    for (int time = 0; time < 5; ++time) {
      for (const ContactResult* result : batch.find(pairs)) expectSame(*result, want, Ids::Ignored);
      noRoom = batch.report().noRoom;
      EXPECT_LE(noRoom, least);
      least = noRoom;
      forSome |= noRoom > 0 && noRoom < pairs.size();
    }
    EXPECT_EQ(noRoom, 0u);
    EXPECT_EQ(forSome, pairs.size() == many.size());
  }
}

// More bins than fit in local memory.
TEST(Batch, PairsOfManyBinsEqualTheFinder) {
  ContactBatch batch({Backend::OpenCl, 1, false});
  SKIP_WITHOUT(batch);
  BodyMaker maker{5e-4, Random(12)};
  const double v = maker.voxel;
  const Thread thread{24 * v, 8 * v, 4.4 * v};
  const Body rod = maker.cloud(threadedRod(thread, 40 * v)),
             ring = maker.cloud(threadedRing(thread, 36 * v, 22 * v, -0.3 * v));
  Pose pose;
  pose.position = Vec3(0.2 * v, -0.1 * v, 0.3 * v);
  pose.orientation = Eigen::Quaterniond(1, 0.002, 0.003, 0.01).normalized();
  BatchPair pair{rod.at({}), ring.at(pose), {}};
  // A third of it are enough hits on the middle level, which has 6,650. All samples would crowd the
  // bins, and the CPU would keep the pair.
  pair.settings.samples = 15000;
  ContactFinder finder;
  for (int time = 0; time < 3; ++time) {
    const auto results = batch.find({&pair, 1});
    expectSame(*results[0], finder.find(pair.a, pair.b, pair.settings));
  }
  EXPECT_EQ(batch.report().onDevice, 1u);
  EXPECT_GT(batch.report().bins, 256u);
}

// Levels that no pair reached in two batches are not searched. A pair that needs one runs on the
// CPU.
TEST(Batch, PairsWithFinerSamplesRunOnTheCpuOnce) {
  ContactBatch batch({Backend::OpenCl, 1, false});
  SKIP_WITHOUT(batch);
  BodyMaker maker{5e-4, Random(9)};
  const Body slab = maker.box(Vec3(16, 16, 8), true);
  Pose pose;
  pose.position = Vec3(0, 0, 7.5 * maker.voxel);
  BatchPair pair{slab.at({}), slab.at(pose), {}};
  ContactFinder finder;
  const std::size_t coarse = 20, fine = 100000,
                    samples[] = {coarse, coarse, coarse, fine, fine, fine};
  for (int step = 0; step < 6; ++step) {
    pair.settings.samples = samples[step];
    const auto results = batch.find({&pair, 1});
    expectSame(*results[0], finder.find(pair.a, pair.b, pair.settings));
    EXPECT_EQ(batch.report().finer, step == 3 ? 1u : 0u) << step;
    // The hits of all samples do not fit the first time.
    EXPECT_EQ(batch.report().noRoom, step == 4 ? 1u : 0u) << step;
  }
}

// Clouds on all plain solids, on either side of the pair and among pairs of clouds, on every level.
std::vector<BatchPair> pairsOfShapes(BodyMaker& maker, std::vector<Body>& bodies) {
  const double v = maker.voxel;
  const std::vector<std::pair<Solid, double>> solids = {
      {HalfSpace{Vec3(0.36, 0.48, 0.8), 2 * v}, 2},
      {Sphere{9 * v}, 9},
      {Sphere{1.5 * v}, 1.5},
      {Box{Vec3(9, 7, 11) * v}, 8},
      {Ellipsoid{Vec3(8, 10, 12) * v}, 9},
      {Capsule{5 * v, 9 * v}, 8},
      {Cylinder{8 * v, 6 * v}, 8},
      {Cone{9 * v, 8 * v, 0}, 5},
      {Cone{9 * v, 8 * v, 2 * v}, 6}};
  bodies.push_back(maker.sphere(10));
  bodies.push_back(maker.box(Vec3(14, 10, 8), true));
  bodies.push_back(maker.cloud(torusMesh(14 * v, 6 * v)));
  const std::size_t clouds = bodies.size();
  for (const auto& solid : solids) bodies.push_back(BodyMaker::shape(solid.first));
  std::vector<BatchPair> pairs;
  for (int k = 0; k < 180; ++k) {
    const std::size_t i = std::size_t(k) % clouds, j = std::size_t(k) / clouds % solids.size();
    const Body &cloud = bodies[i], &shape = bodies[clouds + j];
    Pose pose;
    pose.orientation = maker.random.rotation();
    const double far = (9 + solids[j].second) * v * maker.random.uniform(0.6, 1.0);
    const Vec3 way = j == 0 ? Vec3(0.36, 0.48, 0.8) : Vec3(maker.random.rotation() * Vec3::UnitX());
    pose.position = far * way;
    BatchPair pair{shape.at({}), cloud.at(pose), {}};
    if (k % 2) std::swap(pair.a, pair.b);
    if (k % 5 == 1) pair.settings.samples = 3000;
    if (k % 7 == 2) pair.settings.law = Foundation{1e4, 0};
    if (k % 9 == 4) pair.settings.margin = 1.5 * v;
    pairs.push_back(pair);
    if (k % 20 == 3) pairs.push_back(all().pairs.at(std::size_t(k) / 3));
  }
  return pairs;
}

TEST(Batch, PlainSolidsEqualTheFinder) {
  ContactBatch batch({Backend::OpenCl, 2, false});
  SKIP_WITHOUT(batch);
  BodyMaker maker{5e-4, Random(21)};
  std::vector<Body> bodies;
  const std::vector<BatchPair> pairs = pairsOfShapes(maker, bodies);
  std::vector<ContactFinder> finders(pairs.size());
  std::size_t touching = 0, points = 0;
  for (int time = 0; time < 3; ++time) {
    const auto results = batch.find(pairs);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      SCOPED_TRACE("pair " + std::to_string(k));
      const ContactResult& want = finders[k].find(pairs[k].a, pairs[k].b, pairs[k].settings);
      expectSame(*results[k], want);
      touching += want.samples > 0;
      points += want.points.size();
    }
  }
  EXPECT_GT(touching, 3 * pairs.size() / 2);
  EXPECT_GT(points, 4 * touching);
  // On the CPU: near misses, hits that press nothing, and edges of solids.
  EXPECT_GT(batch.report().onDevice, 3 * pairs.size() / 5);
  EXPECT_EQ(batch.report().noRoom, 0u);
}

// A solid that is a list, a solid's edge in a cloud, and bodies that do not touch.
TEST(Batch, HullsEdgesAndNearMissesRunOnTheCpu) {
  ContactBatch batch({Backend::OpenCl, 1, false});
  SKIP_WITHOUT(batch);
  BodyMaker maker{5e-4, Random(6)};
  const double v = maker.voxel;
  const Body ball = maker.sphere(10), plane = BodyMaker::shape(HalfSpace{}),
             box = BodyMaker::shape(Box{Vec3(8, 8, 8) * v}),
             hull = BodyMaker::shape(test::hullOf({{Vec3(0, 0, 1), 0},
                                                   {Vec3(0, 0, -1), 9 * v},
                                                   {Vec3(1, 0, 0), 9 * v},
                                                   {Vec3(-1, 0, 0), 9 * v},
                                                   {Vec3(0, 1, 0), 9 * v},
                                                   {Vec3(0, -1, 0), 9 * v}}));
  Pose above, beside, corner;
  above.position = Vec3(0, 0, 9.5 * v);
  beside.position = Vec3(21 * v, 0, 0);
  corner.position = Vec3(1, 1, 1).normalized() * (8 * std::sqrt(3.0) + 9) * v;
  std::vector<BatchPair> pairs{{plane.at({}), ball.at(above), {}},
                               {ball.at({}), ball.at(beside), {}},
                               {ball.at({}), ball.at(beside), {}},
                               {hull.at({}), ball.at(above), {}},
                               {box.at({}), ball.at(corner), {}}};
  pairs[1].settings.margin = 1.5 * v;
  batch.find(pairs);
  const auto results = batch.find(pairs);
  ContactFinder finders[5];
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    SCOPED_TRACE("pair " + std::to_string(k));
    expectSame(*results[k], finders[k].find(pairs[k].a, pairs[k].b, pairs[k].settings));
    EXPECT_EQ(results[k]->points.empty(), k == 2);
  }
  EXPECT_EQ(batch.report().shapes, 2u);
  EXPECT_EQ(batch.report().nearMisses, 1u);
  EXPECT_EQ(batch.report().onDevice, 2u);
}

// A new field may get the address of a freed one.
TEST(Batch, NewFieldsAreNotMistakenForFreedOnes) {
  ContactBatch batch({Backend::OpenCl, 1, false});
  SKIP_WITHOUT(batch);
  BodyMaker maker{5e-4, Random(7)};
  for (int k = 0; k < 6; ++k) {
    const Body ball = maker.sphere(6 + k);
    Pose pose;
    pose.position = Vec3((11 + 2 * k) * maker.voxel, 0, 0);
    const BatchPair pair{ball.at({}), ball.at(pose), {}};
    const auto results = batch.find({&pair, 1});
    ContactFinder finder;
    const ContactResult& want = finder.find(pair.a, pair.b, pair.settings);
    EXPECT_FALSE(want.points.empty());
    EXPECT_EQ(results[0]->samples, want.samples);
    ASSERT_EQ(results[0]->points.size(), want.points.size());
    for (std::size_t i = 0; i < want.points.size(); ++i)
      same(results[0]->points[i].depth, want.points[i].depth, "depth");
  }
}

TEST(Batch, BadPosesThrow) {
  BodyMaker maker{5e-4, Random(8)};
  const Body ball = maker.sphere(6);
  BatchPair pair{ball.at({}), ball.at({}), {}};
  pair.b.pose.position.x() = std::nan("");
  for (const Backend backend : {Backend::Cpu, Backend::OpenCl}) {
    ContactBatch batch({backend, 1, false});
    EXPECT_THROW(batch.find({&pair, 1}), std::invalid_argument);
  }
}

// A batch that throws leaves nothing behind.
TEST(Batch, BatchAfterABadPoseIsUnaffected) {
  ContactBatch batch({Backend::OpenCl, 2, false});
  SKIP_WITHOUT(batch);
  BodyMaker maker{5e-4, Random(4)};
  const double v = maker.voxel;
  const Body ball = maker.sphere(8);
  Pose touching, beside;
  touching.position = Vec3(15.5 * v, 0, 0);
  beside.position = Vec3(17 * v, 0, 0);
  // The first part has near misses, which run on the CPU. The second part ends in a bad pose.
  std::vector<BatchPair> pairs(128, {ball.at({}), ball.at(beside), {}});
  for (BatchPair& pair : pairs) pair.settings.margin = 1.5 * v;
  pairs.back().b.pose.position.x() = std::nan("");
  const std::vector<BatchPair> next(3, {ball.at({}), ball.at(touching), {}});
  ContactFinder finder;
  const ContactResult& want = finder.find(next[0].a, next[0].b, next[0].settings);
  for (int time = 0; time < 10; ++time) {
    EXPECT_THROW(batch.find(pairs), std::invalid_argument);
    for (const ContactResult* result : batch.find(next)) expectSame(*result, want, Ids::Ignored);
    EXPECT_EQ(batch.report().onCpu, 0u);
    EXPECT_EQ(batch.report().nearMisses, 0u);
    EXPECT_EQ(batch.report().onDevice, 3u);
  }
}

}  // namespace
}  // namespace cloudcontact::testing::contact_batch_test
