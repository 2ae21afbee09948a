// Slender tips on one axis: the surface nearest to a flank in the other body is the flank on the
// same side, so no surface faces another. They push each other along the axis all the same.
#include <gtest/gtest.h>

#include <cloudcontact/contact/contact_finder.h>

#include <numbers>

#include "field/mesh_field.h"
#include "mesh/test_meshes.h"

namespace cloudcontact::testing::aligned_tips_test {
namespace {

constexpr double kVoxel = 0.05, kHigh = 3;

// A pyramid with a square base of 1 m and its tip at z = kHigh.
Mesh pyramid() {
  const Vec3 tip(0, 0, kHigh);
  const Vec3 base[] = {{-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}, {-0.5, 0.5, 0}};
  Mesh mesh;
  mesh.vertices = {base[0], base[1], base[2], base[3], tip};
  mesh.triangles = {{2, 1, 0}, {3, 2, 0}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  return mesh;
}

class AlignedTips : public ::testing::TestWithParam<double> {
 protected:
  // The other upside down on it, turned about the axis, its tip `deep` below this one's.
  ContactResult found(double deep, double margin, bool swapped = false) {
    static const auto field = fieldOf(pyramid(), kVoxel);
    ContactBody low{field.get(), nullptr, {}, {}}, high = low;
    high.pose.position = Vec3(0, 0, 2 * kHigh - deep);
    high.pose.orientation = Eigen::AngleAxisd(GetParam(), Vec3::UnitZ()) *
                            Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX());
    ContactSettings settings;
    settings.law = KelvinVoigt{1e4, 0};
    settings.margin = margin;
    return finder_.find(swapped ? high : low, swapped ? low : high, settings);
  }
  static Vec3 force(const ContactResult& contact) {
    Vec3 sum = Vec3::Zero();
    for (const ContactPoint& p : contact.points) sum += p.stiffness * p.depth * p.normal;
    return sum;
  }
  ContactFinder finder_;
};

TEST_P(AlignedTips, PushEachOtherAlongTheAxis) {
  double before = 0;
  for (const double deep : {0.02, 0.05, 0.1, 0.2, 0.4}) {
    for (const double margin : {0.0, kVoxel}) {
      const Vec3 push = force(found(deep, margin));
      EXPECT_GT(push.z(), before) << deep << ' ' << margin;
      // Turned by 0.4 rad a few samples near an edge face a flank, and push aside.
      EXPECT_LT(push.head<2>().norm(), (GetParam() < 0.3 ? 0.01 : 1) * push.z())
          << deep << ' ' << margin;
      const Vec3 back = force(found(deep, margin, true));
      EXPECT_NEAR(back.z(), -push.z(), 0.01 * push.z()) << deep << ' ' << margin;
    }
    before = 0.99 * force(found(deep, 0)).z();
  }
}

INSTANTIATE_TEST_SUITE_P(Turns, AlignedTips, ::testing::Values(0.0, 0.2, 0.4));

}  // namespace
}  // namespace cloudcontact::testing::aligned_tips_test
