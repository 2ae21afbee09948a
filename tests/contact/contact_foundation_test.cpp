// The elastic foundation compared with its theory. A pressure k d on a body in a half-space is
// Archimedes' law: the force is k times the volume under the plane, through the center of that
// volume. And the gradient of an energy does no work around a closed path.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "contact/contact_cases.h"

namespace cloudcontact::testing::contact_foundation_test {
namespace {

constexpr double kVoxel = 1e-3;  // [m]

ContactSettings foundation() {
  ContactSettings settings;
  settings.law = Foundation{1e9, 0};  // [N/m^3]
  return settings;
}

std::string nameOf(const ::testing::TestParamInfo<const char*>& param) {
  return testName(param.param);
}

class Archimedes : public ::testing::TestWithParam<const char*> {};

TEST_P(Archimedes, ForceIsTheVolumeUnderThePlane) {
  RunSettings settings;
  settings.voxel = kVoxel;
  settings.instances = 4;
  settings.contact = foundation();
  const ContactCase one = contactCase(GetParam());
  const auto summaries = runCase(one, one.depths, settings);
  for (std::size_t k = 0; k < summaries.size(); ++k) {
    SCOPED_TRACE("pressed by " + std::to_string(one.depths[k]) + " voxels");
    const ErrorSummary& s = summaries[k];
    EXPECT_EQ(s.missed, 0);
    EXPECT_LE(s.worst.normalDeg, 0.5);
    EXPECT_LE(s.worst.center, 0.5);
    EXPECT_LE(s.worst.forceRelative, 0.03);
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, Archimedes,
                         ::testing::Values("sphere16-halfspace", "sphere40-halfspace",
                                           "cylinder24-halfspace", "face-halfspace",
                                           "edge-halfspace", "corner-halfspace"),
                         nameOf);

// A face below a plane tilted by a degree or two, deeper on one side. Four points per patch must
// keep the moment.
TEST(FoundationMoment, OfATiltedFaceIsThatOfTheWedgeBelowThePlane) {
  BodyMaker maker{kVoxel, Random(3)};
  ContactFinder finder;
  const Vec3 edges = Vec3(24, 30, 20) * kVoxel;
  const Body box = maker.box(edges / kVoxel), ground = BodyMaker::shape(HalfSpace{});
  for (const auto& [leanX, leanY] : {std::pair{1.5, 0.0}, {0.0, 1.0}, {1.0, -1.5}}) {
    const double sx = std::tan(leanX * std::numbers::pi / 180);
    const double sy = std::tan(leanY * std::numbers::pi / 180);
    const double depth = 0.9 * kVoxel;  // at the face's center
    // The plane in the box's frame, through the point `depth` above the face's center.
    const Vec3 up = Vec3(sx, sy, 1).normalized();
    const Eigen::Quaterniond turn = shortestTurn(up, Vec3::UnitZ());
    const Vec3 onPlane(0, 0, -edges.z() / 2 + depth);
    const Pose pose{turn, -(turn * onPlane)};
    // The wedge has the height depth - sx x - sy y over the face; first moments in closed form.
    const double area = edges.x() * edges.y(), volume = area * depth;
    const Vec3 center(-sx * edges.x() * edges.x() / 12 / depth,
                      -sy * edges.y() * edges.y() / 12 / depth, onPlane.z());
    const Wrench wrench = wrenchOnB(finder.find(ground.at({}), box.at(pose), foundation()), {}, {});
    const double force = sharedSpring(foundation().law).stiffness * volume;
    EXPECT_NEAR(wrench.force.z(), force, 0.02 * force);
    EXPECT_LE(wrench.force.head<2>().norm(), 0.01 * force);
    // The axis passes through the wedge's center, whose height matters little (tilt^2).
    const Vec3 through = pose.toWorld(center);
    EXPECT_NEAR(-wrench.torque.y() / force, through.x(), 0.1 * kVoxel);
    EXPECT_NEAR(wrench.torque.x() / force, through.y(), 0.1 * kVoxel);
  }
}

// Work of the contact on B along a straight path [J]: total, and the work done against the contact.
struct Work {
  double total = 0, putIn = 0;
};

void travel(Work& work, ContactFinder& finder, const Instance& pair, const Pose& from,
            const Vec3& to, double step) {
  const Vec3 way = to - from.position;
  const int steps = std::max(1, static_cast<int>(std::ceil(way.norm() / step)));
  for (int k = 0; k < steps; ++k) {
    Pose pose = from;
    pose.position += way * ((k + 0.5) / steps);
    const Placed placed{pair.place(0).a, pose, {}};
    const Wrench wrench = wrenchOnB(findContact(finder, pair, placed, {}, foundation()), {}, {});
    const double part = wrench.force.dot(way) / steps;
    work.total += part;
    if (part < 0) work.putIn -= part;
  }
}

// Presses the box onto the table, slides it over the edge and off, lifts it and returns it in the
// air.
Work loopOverEdge(const Instance& pair, double depth) {
  ContactFinder finder;
  Work work;
  Pose pose = pair.place(depth).b;
  const double height = pose.position.z() + depth;
  const auto go = [&](double x, double z, double step) {
    const Vec3 to(x * kVoxel, pose.position.y(), z);
    travel(work, finder, pair, pose, to, step * kVoxel);
    pose.position = to;
  };
  pose.position = {-18 * kVoxel, 0.4 * kVoxel, height + 0.5 * kVoxel};
  go(-18, height - depth, 0.025);
  go(18, height - depth, 0.05);
  go(18, height + 0.5 * kVoxel, 0.1);
  return work;  // the way back, half a voxel above the table, is free
}

class FoundationLoop : public ::testing::TestWithParam<const char*> {};

TEST_P(FoundationLoop, OverATablesEdgeDoesNoWork) {
  BodyMaker maker{kVoxel, Random(5)};
  for (int k = 0; k < 2; ++k) {
    const Instance pair = contactCase(GetParam()).make(maker);
    for (const double depth : {0.5, 1.0}) {
      const Work work = loopOverEdge(pair, depth * kVoxel);
      EXPECT_GT(work.putIn, 0);
      EXPECT_LE(std::abs(work.total), 0.01 * work.putIn)
          << "instance " << k << " at depth " << depth;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, FoundationLoop,
                         ::testing::Values("overhang", "overhang-aligned", "overhang-yawed"),
                         nameOf);

}  // namespace
}  // namespace cloudcontact::testing::contact_foundation_test
