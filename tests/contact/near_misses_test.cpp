// Bodies that nearly touch: the gap is that of the bodies and of all their samples, a touch is
// never taken for a gap, and few samples are asked.
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/voxels/digitize.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "contact/contact_cases.h"
#include "contact/hit_search.h"
#include "field/mesh_field.h"
#include "mesh/feet_meshes.h"
#include "mesh/thread_meshes.h"

namespace cloudcontact::testing::near_misses_test {
namespace {

constexpr double kVoxel = 1e-3, kMargin = kVoxel;

struct Found {
  bool touching = false;
  double gap = kMargin;  // [m]
  std::size_t lookups = 0;
};

Found searched(const ContactBody& a, const ContactBody& b) {
  HitSearch search;
  HitColumns hits;
  const PairFrame frame = frameOf(a, b);
  search.run(a, b, frame, kMargin, ContactSettings::kSamples, hits);
  Found found{search.gap() == 0 && !hits.empty(), kMargin, search.lookups()};
  if (search.gap() > 0) found.gap = search.gap() - NearMissSearch::kLightly * frame.voxel;
  return found;
}

// Of all samples of one body, the depth of the deepest in the other [m].
double deepestOf(const ContactBody& own, const ContactBody& other) {
  const Pose map = other.pose.inverse() * own.pose;
  const Cloud& cloud = own.field->cloud();
  double deepest = -1e30;
  for (std::size_t k = 0; k < own.field->sampleCount(); ++k) {
    const SurfaceSample s = own.field->sample(k);
    const Vec3 at(s.position[0], s.position[1], s.position[2]);
    const Vec3 there = map.toWorld(cloud.origin() + cloud.voxelSize() * at);
    if (other.shape)
      deepest = std::max(deepest, solidAt(*other.shape, there).depth);
    else if (const auto point = other.field->at(there))
      deepest = std::max(deepest, point->depth);
  }
  return deepest;
}

double deepestOfAll(const ContactBody& a, const ContactBody& b) {
  double deepest = -1e30;
  if (a.field) deepest = deepestOf(a, b);
  if (b.field) deepest = std::max(deepest, deepestOf(b, a));
  return deepest;
}

// The gap against that of the bodies; swapped; with the world turned.
void expectGap(const ContactBody& a, const ContactBody& b, double gap, double tolerance,
               Random& random, const std::string& what) {
  const Found found = searched(a, b);
  ASSERT_FALSE(found.touching) << what;
  EXPECT_NEAR(found.gap / kVoxel, gap / kVoxel, tolerance) << what;
  EXPECT_NEAR(searched(b, a).gap / kVoxel, found.gap / kVoxel, 0.01) << what << ", swapped";
  const Pose world{random.rotation(), random.inCube()};
  ContactBody c = a, d = b;
  c.pose = world * a.pose;
  d.pose = world * b.pose;
  EXPECT_NEAR(searched(c, d).gap / kVoxel, found.gap / kVoxel, 0.02) << what << ", turned";
}

// The gap against that of all samples. Beyond the other's edges its planes tell less than the way.
void expectNearest(const ContactBody& a, const ContactBody& b, const std::string& what) {
  EXPECT_NEAR(searched(a, b).gap / kVoxel, -deepestOfAll(a, b) / kVoxel, 0.05) << what;
}

constexpr double kGaps[] = {0.15, 0.3, 0.6, 0.9};  // [voxels]

Pose above(double height) {
  Pose pose;
  pose.position = Vec3(0.3 * kVoxel, -0.2 * kVoxel, height);
  return pose;
}

// A face over a face, a ball over a face, and a ball over a ball, as clouds and over formulas.
TEST(NearMisses, SmoothBodies) {
  BodyMaker make{kVoxel, Random(3), {}};
  Random random(4);
  const Body slab = make.box({40, 40, 12}), cube = make.box({14, 14, 14}), ball = make.sphere(9);
  const Body plane = BodyMaker::shape(HalfSpace{Vec3::UnitZ(), 6 * kVoxel});
  for (const double gap : kGaps) {
    const std::string what = std::to_string(gap) + " voxels";
    for (const Body* floor : {&slab, &plane}) {
      const ContactBody a = floor->at(Pose{}), c = cube.at(above((13 + gap) * kVoxel)),
                        b = ball.at(above((15 + gap) * kVoxel));
      expectGap(a, c, gap * kVoxel, 0.08, random, "cube, " + what);
      expectGap(a, b, gap * kVoxel, 0.08, random, "ball, " + what);
      expectNearest(a, c, "cube, " + what);
      expectNearest(a, b, "ball, " + what);
    }
    Pose beside;
    beside.position = (18 + gap) * kVoxel * Vec3(1, 2, -1).normalized();
    expectGap(ball.at(Pose{}), ball.at(beside), gap * kVoxel, 0.1, random, "two balls, " + what);
    expectNearest(ball.at(Pose{}), ball.at(beside), "two balls, " + what);
  }
}

// An edge and a corner over a face: the samples there lean.
TEST(NearMisses, EdgesAndCorners) {
  BodyMaker make{kVoxel, Random(5), {}};
  Random random(6);
  const Body slab = make.box({40, 40, 12}), cube = make.box({14, 14, 14});
  const Eigen::Quaterniond onEdge(Eigen::AngleAxisd(0.25 * M_PI, Vec3::UnitX()));
  const Eigen::Quaterniond onCorner = shortestTurn(Vec3(1, 1, 1).normalized(), -Vec3::UnitZ());
  for (const double gap : {0.3, 0.6}) {
    for (const auto& [turn, half] :
         {std::pair(onEdge, 7 * std::sqrt(2.0)), std::pair(onCorner, 7 * std::sqrt(3.0))}) {
      Pose pose = above((6 + half + gap) * kVoxel);
      pose.orientation = turn;
      expectGap(slab.at(Pose{}), cube.at(pose), gap * kVoxel, 0.1, random,
                std::to_string(gap) + " voxels, half " + std::to_string(half));
    }
  }
}

// Rod and ring with the same thread of flat crests and roots, or with none: the gap is even, every
// sample is near, but for the ring's chamfered ends.
struct Threaded {
  std::shared_ptr<const SurfaceField> rod, ring;
  double gap;  // [m]

  explicit Threaded(double depth) {
    constexpr double kRadius = 30 * kVoxel, kPitch = 12 * kVoxel, kPlay = 0.7 * kVoxel, kSteep = 2;
    const auto radius = [=](double angle, double z) {
      const double turn = z / kPitch - angle / (2 * M_PI);
      const double rise = 2 * std::abs(turn - std::floor(turn) - 0.5);
      return kRadius - depth * kVoxel * std::clamp(kSteep * rise - 0.5, 0.0, 1.0);
    };
    const auto at = [](double r, double angle, double z) {
      return Vec3(r * std::cos(angle), r * std::sin(angle), z);
    };
    gap = kPlay / std::hypot(1, kSteep * depth / 6);
    const auto half = [](double s, double length) {
      return length * (std::clamp(1.02 * s - 0.01, 0.0, 1.0) - 0.5);
    };
    const Mesh inner = revolvedMesh(180, 400, false, [&](double angle, double s) {
      const double z = half(s, 70 * kVoxel);
      return at(s == 0 || s == 1 ? 0 : radius(angle, z), angle, z);
    });
    const Mesh outer = revolvedMesh(180, 600, true, [&](double angle, double s) {
      const double z = half(s < 0.5 ? 2 * s : 2 - 2 * s, 40 * kVoxel);
      const double chamfer = std::max(0.0, std::abs(z) - 15 * kVoxel);
      return at(s < 0.5 ? radius(angle, z) + kPlay + chamfer : 45 * kVoxel, angle, z);
    });
    DigitizeSettings settings;
    settings.voxelSize = kVoxel;
    rod = SurfaceField::build(digitize(inner, settings));
    ring = SurfaceField::build(digitize(outer, settings));
  }
};

TEST(NearMisses, ANutInItsPlayAsksFewSamples) {
  for (const double depth : {0.0, 5.0}) {
    const Threaded pair(depth);
    ContactBody a, b;
    a.field = pair.rod.get();
    b.field = pair.ring.get();
    Random random(7);
    for (int k = 0; k < 10; ++k) {
      b.pose.position = 0.05 * kVoxel * random.inCube();
      const Found found = searched(a, b);
      EXPECT_FALSE(found.touching) << "thread " << depth << ", pose " << k;
      EXPECT_NEAR(found.gap / kVoxel, pair.gap / kVoxel, 0.2) << "thread " << depth;
      const std::size_t all = pair.rod->sampleCount() + pair.ring->sampleCount();
      EXPECT_LT(found.lookups, all / 2) << "thread " << depth << ", of " << all;
    }
  }
}

// Where any sample lies in the other body, the bodies touch.
TEST(NearMisses, NoTouchIsMissed) {
  const Threaded pair(5);
  BodyMaker make{kVoxel, Random(8), {}};
  const Body slab = make.box({40, 40, 12}), small = make.sphere(2.5), cube = make.box({9, 7, 5});
  Random random(9);
  int touching = 0;
  for (int k = 0; k < 300; ++k) {
    ContactBody a = slab.at(Pose{}), b = k % 3 ? small.at(above(0)) : cube.at(above(0));
    if (k % 10 == 0) a.field = pair.rod.get(), b.field = pair.ring.get();
    if (k % 10 == 0) {
      a.pose = b.pose = Pose{};
      b.pose.position = 1.2 * kVoxel * (random.inCube() - Vec3::Constant(0.5));
    } else {
      b.pose = Pose{random.rotation(), Vec3::Zero()};
      b.pose.position.x() = 20 * kVoxel * (random.uniform() - 0.5);
      b.pose.position.z() = kVoxel * random.uniform(7.5, 11.5);
    }
    const double deepest = deepestOfAll(a, b);
    touching += deepest > 0;
    if (deepest > 0.02 * kVoxel) {
      EXPECT_TRUE(searched(a, b).touching) << "pose " << k << ", deepest " << deepest / kVoxel;
    }
  }
  EXPECT_GT(touching, 50);
  EXPECT_LT(touching, 280);
}

// Samples on the sides of a box reach half their width below it: hits that press nothing, which
// must not hide the gap. Flat faces, along their grids and turned on each other, where the same
// samples may touch 0.2 voxel early.
TEST(NearMisses, FlatFacesAreSeenAtAnyGap) {
  const auto box = fieldOf(boxMesh(Vec3(20, 20, 10) * kVoxel), kVoxel);
  for (const double coarse : {1.0, 2.0}) {
    const auto slab = fieldOf(boxMesh(Vec3(60, 60, 20) * kVoxel), coarse * kVoxel);
    for (const double turn : {0.0, 0.3})
      for (const double gap : {0.01, 0.05, 0.1, 0.12, 0.15, 0.3, 0.9}) {
        ContactBody a, b;
        a.field = slab.get(), b.field = box.get();
        a.pose.position = Vec3(0, 0, -10 * kVoxel);
        b.pose.position = Vec3(0, 0, (5 + gap) * kVoxel);
        b.pose.orientation = Eigen::AngleAxisd(turn, Vec3::UnitZ());
        ContactSettings settings;
        settings.margin = kMargin;
        ContactFinder finder;
        const ContactResult& found = finder.find(a, b, settings);
        ASSERT_FALSE(found.points.empty()) << gap << " voxel, turned by " << turn;
        for (const ContactPoint& p : found.points)
          EXPECT_NEAR(p.depth / kVoxel, -gap, turn > 0 ? 0.22 : 0.04);
      }
  }
}

// Which samples stand for a face must not depend on their order, nor on a tilt far below the voxel:
// bodies that meet face to face would turn about that part.
TEST(NearMisses, FlatFacesAreSeenWhole) {
  const auto box = fieldOf(boxMesh(Vec3(20, 20, 10) * kVoxel), kVoxel);
  const auto slab = fieldOf(boxMesh(Vec3(60, 60, 20) * kVoxel), kVoxel);
  for (const double tilt : {0.0, 1e-6, 2e-4})
    for (const double gap : {0.05, 0.3, 0.9}) {
      SCOPED_TRACE(std::to_string(gap) + " voxel, tilted by " + std::to_string(tilt));
      ContactBody a, b;
      a.field = slab.get(), b.field = box.get();
      a.pose.position = Vec3(0, 0, -10 * kVoxel);
      b.pose.orientation = Eigen::AngleAxisd(tilt, Vec3::UnitX());
      b.pose.position = b.pose.orientation * Vec3(0, 0, 5 * kVoxel) + Vec3(0, 0, gap * kVoxel);
      ContactSettings settings;
      settings.margin = kMargin;
      ContactFinder finder;
      const ContactResult& found = finder.find(a, b, settings);
      ASSERT_EQ(found.patches.size(), 1u);
      EXPECT_NEAR(found.patches[0].area / (kVoxel * kVoxel), 400, 25);
      EXPECT_LT(found.patches[0].position.head<2>().norm(), 0.5 * kVoxel);
      double least = 1, most = -1;
      for (const ContactPoint& p : found.points) {
        const double off = p.depth / kVoxel + gap + tilt * p.position.y() / kVoxel;
        EXPECT_NEAR(off, 0, 1e-3);
        least = std::min(least, off), most = std::max(most, off);
      }
      EXPECT_LT(most - least, 2e-4);
    }
}

// A near miss reads as a touch does. A ball that nearly touches a plane has its force on its axis:
// beside it, it would spin as it bounces.
TEST(NearMisses, ABallIsAsFarAsItIs) {
  BodyMaker make{kVoxel, Random(11), {}};
  Random random(12);
  const Body ball = make.sphere(10), plane = BodyMaker::shape(HalfSpace{Vec3::UnitZ(), 0});
  for (const double gap : {0.01, 0.3, 1.0, 3.0}) {
    double squareOfDepth = 0, squareOfPlace = 0;
    constexpr int kPoses = 50;
    for (int k = 0; k < kPoses; ++k) {
      const Pose pose{random.rotation(), Vec3(0, 0, (10 + gap) * kVoxel)};
      ContactSettings settings;
      settings.margin = 4 * kVoxel;
      ContactFinder finder;
      ContactResult found;
      finder.search(ball.at(pose), plane.at(Pose{}), settings, found);
      ASSERT_EQ(found.points.size(), 4u);
      double depth = 0;
      Vec3 place = Vec3::Zero();
      for (const ContactPoint& p : found.points) {
        depth += 0.25 * p.depth / kVoxel;
        place += 0.25 * p.position / kVoxel;
        EXPECT_LT(p.normal.head<2>().norm(), 0.03);
      }
      squareOfDepth += (depth + gap) * (depth + gap) / kPoses;
      squareOfPlace += place.head<2>().squaredNorm() / kPoses;
    }
    EXPECT_LT(std::sqrt(squareOfDepth), 0.005) << gap;
    EXPECT_LT(std::sqrt(squareOfPlace), 0.035) << gap;
  }
}

// Of a tip on a plane, the depth grows by the approach, from before the touch to after it: what
// stands on tips is else held up at another height by what is near than by what touches. Feet
// differ by what the field knows of each, and each must agree with itself.
TEST(NearMisses, ATipIsAsFarAsItsTouchIsDeep) {
  constexpr double kHigh = 60e-3, kCoarse = 5e-3;
  const auto field = fieldOf(test::feetMesh(test::tipMesh(kHigh), 0.2, 0.15), kCoarse);
  const Solid plane = HalfSpace{};
  for (const double turned : {0.0, 0.4, 1.1}) {
    // The mean depth of each foot's points, less by how far it is in.
    const auto lag = [&](double in) {
      ContactBody table, ground;
      table.field = field.get();
      table.pose.position.z() = -in;
      table.pose.orientation = Eigen::AngleAxisd(turned, Vec3::UnitZ());
      ground.shape = &plane;
      ContactSettings settings;
      settings.margin = 0.5 * kCoarse;
      ContactFinder finder;
      std::array<double, 4> mean{};
      std::array<int, 4> count{};
      for (const ContactPoint& p : finder.find(table, ground, settings).points) {
        const Vec3 at = table.pose.toLocal(p.position);
        const auto foot = static_cast<std::size_t>((at.x() > 0) + 2 * (at.y() > 0));
        mean[foot] += p.depth - in;
        ++count[foot];
      }
      for (std::size_t k = 0; k < 4; ++k) {
        EXPECT_GT(count[k], 0) << in;
        mean[k] /= std::max(1, count[k]);
      }
      return mean;
    };
    const auto touching = lag(0.03 * kCoarse), near = lag(0), far = lag(-0.2 * kCoarse);
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_NEAR(near[k], touching[k], 8e-4 * kCoarse) << turned << ", " << k;
      EXPECT_NEAR(far[k], near[k], 1e-6 * kCoarse) << turned << ", " << k;
    }
  }
}

}  // namespace
}  // namespace cloudcontact::testing::near_misses_test
