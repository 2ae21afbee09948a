// Where the points of a contact stand, what depth they state, and what force they make together.
#include <gtest/gtest.h>

#include <cloudcontact/contact/contact_finder.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <random>

#include "contact/contact_cases.h"
#include "contact/pressed_parts.h"
#include "field/mesh_field.h"
#include "kernels/contact/patch_force.h"
#include "mesh/turned_mesh.h"

namespace cloudcontact::testing::contact_points_test {
namespace {

// How far the points may be from both surfaces beyond half the overlap, since they stand midway
// between them [voxels].
constexpr double kOff = 0.5;
// Of the force: a patch that bears less is a crumb of an edge, such as where a nut's thread runs
// out in its end face.
constexpr double kCrumb = 0.01;

class ContactPoints : public ::testing::TestWithParam<const char*> {
 protected:
  // Calls check(pair, contact) for every pair of the kind.
  template <typename Check>
  static void forEach(const Check& check) {
    for (const PressedPair& pair : pressedPairs(GetParam())) {
      SCOPED_TRACE(pair.name + ", overlap " + std::to_string(pair.overlap / pair.a->voxel));
      ContactFinder finder;
      const ContactResult& contact =
          finder.find(pair.a->at(pair.poseA), pair.b->at(pair.poseB), {});
      ASSERT_FALSE(contact.points.empty());
      check(pair, contact);
    }
  }
};

// A point in a hundred of a thread may be off, where weights end that would keep the center of
// pressure.
TEST_P(ContactPoints, StandMidwayBetweenBothSurfaces) {
  int all = 0, off = 0;
  forEach([&](const PressedPair& pair, const ContactResult& contact) {
    const double most = kOff * pair.a->voxel + pair.overlap / 2;
    double force = 0;
    for (const Patch& patch : contact.patches) force += patch.stiffness * patch.depth;
    for (const ContactPoint& p : contact.points) {
      const Patch& patch = contact.patches[static_cast<std::size_t>(p.patch)];
      if (patch.stiffness * patch.depth < kCrumb * force) continue;
      ++all;
      const double away = std::max(std::abs(pair.a->outside(pair.poseA.toLocal(p.position))),
                                   std::abs(pair.b->outside(pair.poseB.toLocal(p.position))));
      if (away <= most) continue;
      ++off;
      if (GetParam() != std::string("threads")) ADD_FAILURE() << away / pair.a->voxel << " off";
    }
  });
  EXPECT_GT(all, 10);
  EXPECT_LE(100 * off, all);
}

TEST_P(ContactPoints, LargestDepthIsTheOverlap) {
  // On a corner the pair's own depth is off by up to a quarter of a voxel (docs/limits.md).
  const double most = GetParam() == std::string("corners") ? 0.25 : 0.1;
  forEach([most](const PressedPair& pair, const ContactResult& contact) {
    double deepest = 0;
    for (const ContactPoint& p : contact.points) deepest = std::max(deepest, p.depth);
    EXPECT_NEAR(deepest / pair.a->voxel, pair.overlap / pair.a->voxel,
                std::max(0.1 * pair.overlap / pair.a->voxel, most));
  });
}

// A patch's force, its depth times its stiffness, comes from the sums over all its hits and acts at
// its center of pressure. Its points have the same force, and no moment there but a spin.
TEST_P(ContactPoints, ForceIsThatOfTheSums) {
  forEach([](const PressedPair& pair, const ContactResult& contact) {
    double stiffness = 0, slope = 0, sum = 0;
    for (const Patch& patch : contact.patches) {
      Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
      for (int i = patch.firstPoint; i < patch.firstPoint + patch.points; ++i) {
        const ContactPoint& p = contact.points[static_cast<std::size_t>(i)];
        force += p.stiffness * p.depth * p.normal;
        moment += (p.position - patch.position).cross(p.stiffness * p.depth * p.normal);
        slope += p.slope;
      }
      const double size = patch.stiffness * patch.depth;
      EXPECT_LT((force - size * patch.normal).norm(), 1e-9 * size);
      EXPECT_LT((moment - moment.dot(patch.normal) * patch.normal).norm(),
                1e-9 * size * pair.a->voxel);
      stiffness += patch.stiffness;
      sum += size;
    }
    const double k = std::get<KelvinVoigt>(ContactSettings{}.law).stiffness;
    EXPECT_NEAR(stiffness, k, 1e-9 * k);
    EXPECT_NEAR(slope, k, 1e-9 * k);
    EXPECT_NEAR(sum, k * depthOf(contact), 1e-9 * sum);
  });
}

INSTANTIATE_TEST_SUITE_P(Kinds, ContactPoints,
                         ::testing::Values("tori", "rings", "pegs", "boxes", "corners", "round",
                                           "threads"));

// A ring that is pressed on one side more and more becomes an arc. Its points go along: in a step
// of 0.0006 voxel none goes farther than its nearest sample may change.
TEST(ContactPointsOnTheWay, FollowARingThatBecomesAnArc) {
  const std::vector<PressedPair> pairs = pressedPairs("tori");
  const PressedPair& coaxial = pairs.front();
  ContactFinder finder;
  ContactResult before;
  const double voxel = coaxial.a->voxel;
  for (double tilt = 0; tilt < 0.04; tilt += 2e-5) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(tilt, Vec3::UnitX()));
    const Pose poseB = coaxial.poseA * Pose{turn, Vec3(0, 0, 19.5 + 30 * tilt) * voxel};
    const ContactResult& now = finder.find(coaxial.a->at(coaxial.poseA), coaxial.b->at(poseB), {});
    ASSERT_FALSE(now.points.empty());
    for (std::size_t i = 0; !before.points.empty() && i < now.points.size(); ++i) {
      const double way = (now.points[i].position - before.points[i].position).norm();
      EXPECT_LT(way / voxel, 7) << "tilt " << tilt << ", point " << i;
    }
    before = now;
  }
}

// Plates that have passed each other have both of their sides in a patch, and normals of all
// directions. What points press beside their patch's normal the others take back: with normals
// across it a patch of a few newtons would have points of thousands, and a solver that does not
// find all of them would throw the bodies apart.
TEST(PatchPoints, OfPassedPlatesPressHardlyMoreThanTheirPatch) {
  const double voxel = 0.03;
  const auto plate = fieldOf(boxMesh({1, 0.8, 0.1}), voxel);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-1, 1);
  ContactFinder finder;
  int patches = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 axis = Vec3(any(random), any(random), any(random));
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(3 * any(random), axis.normalized()));
    const Vec3 place(0.4 * any(random), 0.3 * any(random), 0.3 * any(random));
    ContactBody a, b;
    a.field = b.field = plate.get();
    b.pose = {turn, place};
    const ContactResult& contact = finder.find(a, b, {});
    for (const Patch& patch : contact.patches) {
      double pressed = 0;
      for (int k = patch.firstPoint; k < patch.firstPoint + patch.points; ++k) {
        const ContactPoint& p = contact.points[static_cast<std::size_t>(k)];
        pressed += p.stiffness * p.depth;
      }
      ++patches;
      EXPECT_LT(pressed, 2.3 * patch.stiffness * patch.depth) << "pose " << i;
    }
  }
  EXPECT_GT(patches, 300);
}

// Root mean square of how far the points stand from their middle, across z [m]; 0 without points.
double spreadOf(const ContactResult& contact) {
  if (contact.points.empty()) return 0;
  Vec3 middle = Vec3::Zero();
  for (const ContactPoint& p : contact.points)
    middle += p.position / static_cast<double>(contact.points.size());
  double sum = 0;
  for (const ContactPoint& p : contact.points) sum += (p.position - middle).head<2>().squaredNorm();
  return std::sqrt(sum / static_cast<double>(contact.points.size()));
}

// A ball rolls on its patch, a foot rests on it, though the normals of its chamfer lean outwards as
// those of the ball do. Pressed by a thousandth of a voxel to a quarter.
TEST(PatchPoints, StandTogetherUnderABallAndApartUnderAFoot) {
  const double voxel = 0.05, r = 0.4, h = 0.5, c = 0.05;
  const auto ball = fieldOf(sphereMesh(1, 2e-4), voxel);
  const auto foot =
      fieldOf(test::turnedMesh({{0, -h}, {r - c, -h}, {r, c - h}, {r, h}, {0, h}}, 144), voxel);
  const Solid ground = HalfSpace{};
  ContactFinder finder;
  const auto spread = [&](const SurfaceField& field, double height) {
    ContactBody a, b;
    a.shape = &ground;
    b.field = &field;
    b.pose.position = {0.013, 0.021, height};
    return spreadOf(finder.find(a, b, {}));
  };
  // The foot's rim stands out by some tenths of a voxel.
  double touch = h + 0.5 * voxel;
  while (spread(*foot, touch) == 0) touch -= 1e-3 * voxel;
  for (const double depth : {0.001, 0.003, 0.01, 0.03, 0.1, 0.25}) {
    EXPECT_LT(spread(*ball, 1 - depth * voxel), 0.3 * voxel) << depth;
    EXPECT_GT(spread(*foot, touch - depth * voxel), 0.5 * r) << depth;
  }
}

// Points in one place cannot share a moment by their weights. One of the least weight may be below
// it by rounding, which is no reason to divide by nothing.
TEST(PatchPoints, StayWhereTheyAreIfTheyCoincide) {
  CcPlan plan = {};
  plan.voxel = 1e-3;
  const double least = CC_LEAST_WEIGHT * (1 - 1e-15), weights[4] = {least, 1, 1, 2 - least};
  std::copy_n(weights, 4, plan.weight);
  ccBalance(&plan);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(plan.weight[i], weights[i]);
    EXPECT_TRUE(std::isfinite(plan.at[i].u) && std::isfinite(plan.at[i].v));
  }
}

}  // namespace
}  // namespace cloudcontact::testing::contact_points_test
