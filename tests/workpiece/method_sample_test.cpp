// The sample of docs/method.md: compiled and run here, and compared with the document to the
// letter.
#include <gtest/gtest.h>

#include <cloudcontact/voxels/digitize.h>
#include <cloudcontact/workpiece/haptic_loop.h>

#include "base/document_sample.h"
#include "mesh/test_meshes.h"

namespace cloudcontact::method_sample_test {
namespace {

TEST(Method, Sample) {
  const std::vector<NamedMesh> parts = {{"enamel", test::sphereMesh(4e-3, 4)},
                                        {"dentin", test::sphereMesh(2.8e-3, 4)}};
  const Pose handPose{Eigen::Quaterniond::Identity(), Vec3(0, 0, 4.3e-3)};
  const Vec3 handVelocity = Vec3::Zero();
  // haptics begins
  DigitizeSettings settings;
  settings.voxelSize = 1e-4;                // meters
  Cloud tooth = digitize(parts, settings);  // meshes named enamel, dentin ...
  BaseVectorField field(tooth, tissuesOf(dentalTissues(), tooth.materials()),
                        sphereWindow(tooth.voxelSize()));  // C: 2.5 voxels about each voxel

  HapticSettings haptics;
  haptics.tool.area = {Sphere{0.5e-3}};   // D: a round bur of 1 mm
  haptics.cutter = Cutter{17e9, 0.1, 5};  // tungsten carbide, a tenth comes off, edges at 5 m/s
  HapticLoop loop(field, Pose{}, haptics);
  HapticOutput out = loop.tick({handPose, handVelocity});  // every millisecond
  // haptics ends
  EXPECT_GT(out.onHand.force.z(), 0.05);
  EXPECT_LT(out.onHand.force.z(), 0.2 * 1000 * 1e-3);
}

TEST(Method, SampleEqualsTheDocument) {
  testing::expectSample("docs/method.md", "haptics", "tests/workpiece/method_sample_test.cpp");
}

}  // namespace
}  // namespace cloudcontact::method_sample_test
