// A contact does not depend on the order of the bodies, on the pose of the pair in the world, or on
// its size, from micrometers to meters.
#include <gtest/gtest.h>

#include "contact/contact_cases.h"

namespace cloudcontact::testing::contact_invariance_test {
namespace {

constexpr double kVoxel = 1e-3;     // [m]
constexpr double kSame = 1e-4;      // relative error of the force
constexpr double kLever = 30;       // [voxels] a body's size, the lever arm for moments
constexpr double kPressedBy = 0.6;  // voxels

std::string nameOf(const ::testing::TestParamInfo<const char*>& param) {
  return testName(param.param);
}

class ContactInvariance : public ::testing::TestWithParam<const char*> {};

// The wrench on B about the true center, in the case's frame [N], [N m].
Wrench seenFromCase(const ContactResult& found, const Placed& placed, const Pose& world) {
  const Wrench wrench = wrenchOnB(found, {}, {});
  const Vec3 center = world.toWorld(placed.truth.center);
  return {world.orientation.conjugate() * wrench.force,
          world.orientation.conjugate() * (wrench.torque - center.cross(wrench.force))};
}

void expectSame(const Wrench& found, const Wrench& expected, double voxel) {
  const double force = expected.force.norm();
  ASSERT_GT(force, 0);
  EXPECT_LE((found.force - expected.force).norm(), kSame * force);
  EXPECT_LE((found.torque - expected.torque).norm(), kSame * force * kLever * voxel);
}

TEST_P(ContactInvariance, SwappedMovedAndTurned) {
  BodyMaker maker{kVoxel, Random(7)};
  ContactFinder finder;
  for (int k = 0; k < 2; ++k) {
    const Instance instance = contactCase(GetParam()).make(maker);
    const Placed placed = instance.place(kPressedBy * kVoxel);
    const Wrench here = seenFromCase(findContact(finder, instance, placed, {}, {}), placed, {});
    Wrench other = seenFromCase(findContact(finder, instance, placed, {}, {}, true), placed, {});
    other.force = -other.force;
    other.torque = -other.torque;
    {
      SCOPED_TRACE("swapped");
      expectSame(other, here, kVoxel);
    }
    SCOPED_TRACE("moved and turned");
    const Pose world{maker.random.rotation(), 5 * maker.random.inCube()};
    expectSame(seenFromCase(findContact(finder, instance, placed, world, {}), placed, world), here,
               kVoxel);
  }
}

TEST_P(ContactInvariance, ScaledFromMicrometersToMeters) {
  std::vector<Wrench> wrenches;
  const std::vector<double> voxels{kVoxel, 1e-3 * kVoxel, 100 * kVoxel};
  for (const double voxel : voxels) {
    BodyMaker maker{voxel, Random(11)};
    ContactFinder finder;
    const Instance instance = contactCase(GetParam()).make(maker);
    const Placed placed = instance.place(kPressedBy * voxel);
    Wrench wrench = seenFromCase(findContact(finder, instance, placed, {}, {}), placed, {});
    // The paper's force is proportional to depth, its moment also to the lever arm.
    wrench.force *= kVoxel / voxel;
    wrench.torque *= kVoxel / voxel * kVoxel / voxel;
    wrenches.push_back(wrench);
  }
  for (std::size_t k = 1; k < voxels.size(); ++k) {
    SCOPED_TRACE("voxels of " + std::to_string(voxels[k]) + " m");
    expectSame(wrenches[k], wrenches[0], kVoxel);
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, ContactInvariance,
                         ::testing::Values("sphere24-halfspace", "sphere16-sphere40",
                                           "cylinder24-slab", "face-slab", "face-stack-aligned",
                                           "overhang", "edge-slab", "corner-slab", "crossed60",
                                           "primitive-cylinder16", "plate3-slab"),
                         nameOf);

}  // namespace
}  // namespace cloudcontact::testing::contact_invariance_test
