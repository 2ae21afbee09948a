// A real-time loop must not wait for memory: after the first contact no tick allocates, with or
// without cutting.
#include <gtest/gtest.h>

#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/workpiece/haptic_loop.h>

#include "base/counted_new.h"
#include "voxels/small_clouds.h"

namespace cloudcontact::no_allocation_test {
namespace {

constexpr double kVoxel = 1e-4;

class HapticTick : public ::testing::TestWithParam<Search> {};

TEST_P(HapticTick, AllocatesNothing) {
  BaseVectorField field(test::smallCloud(
                            kVoxel, {6, 6, 6}, [](int, int, int z) { return z < 30 ? 255 : 0; },
                            {"enamel", "dentin"}, [](int, int, int z) { return z > 22 ? 0 : 1; }),
                        {dentalTissues()[0], dentalTissues()[1]}, sphereWindow(kVoxel));
  HapticSettings settings;
  settings.tool.area = {Sphere{6 * kVoxel}};
  settings.tool.parts.push_back(
      {PlacedSolid{Sphere{3 * kVoxel}, {.position = Vec3(0, 0, -6 * kVoxel)}}, 2});
  settings.cutter = Cutter{17e9, 0.5, 10};
  settings.law = StandardLinearSolid{1, 1, 1};
  settings.perTissue = true;
  settings.embedding.search = GetParam();
  HapticLoop loop(field, {}, settings);
  std::size_t before = 0, cut = 0;
  double deepest = 0;
  for (int k = 0; k < 2000; ++k) {
    // Down through the enamel into the dentin, back and forth, and out again.
    const double down = k < 1500 ? 3e-6 * k : 3e-6 * 1500 - 2e-5 * (k - 1500);
    const Vec3 place(24 * kVoxel + 5e-4 * std::sin(0.01 * k), 24 * kVoxel, 36.5 * kVoxel - down);
    const HapticOutput& out = loop.tick({{Eigen::Quaterniond::Identity(), place}});
    cut += out.cutVoxels;
    deepest = std::max(deepest, out.depth);
    if (k == 0) before = allocations;
  }
  EXPECT_EQ(allocations - before, 0u);
  EXPECT_GT(cut, 1000u);
  EXPECT_GT(deepest, kVoxel);
}

INSTANTIATE_TEST_SUITE_P(NoAllocation, HapticTick,
                         ::testing::Values(Search::Newton, Search::Table));

// A contact at rest does not allocate either, from its second query on.
TEST(NoAllocation, InAContactAtRest) {
  const auto slab = [](int bricks) {
    return SurfaceField::build(test::smallCloud(
        kVoxel, {bricks, bricks, 2},
        [=](int x, int y, int z) {
          const bool in = std::min({x, y, z}) > 1 && std::max(x, y) < 8 * bricks - 2 && z < 12;
          return in ? 255 : 0;
        },
        {"steel"}));
  };
  const auto lower = slab(5), upper = slab(3);
  ContactBody a{lower.get(), nullptr, {}, {}}, b{upper.get(), nullptr, {}, {}};
  b.pose.position = kVoxel * Vec3(8.3, 7.1, 9.7);
  const auto workspace = std::make_shared<ContactWorkspace>();
  ContactFinder first(workspace), second(workspace);
  ContactResult found;
  for (int i = 0; i < 3; ++i) first.find(a, b, {});  // grows the workspace
  second.find(a, b, {}, found);
  const std::size_t before = allocations;
  for (int i = 0; i < 3; ++i) second.find(a, b, {}, found);
  EXPECT_EQ(allocations - before, 0u);
}

}  // namespace
}  // namespace cloudcontact::no_allocation_test
