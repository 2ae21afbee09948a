// Clouds that slide 10 m over a terrain of 200,000 triangles: inner edges do not stop them.
#include <gtest/gtest.h>

#include "bullet/slide_course.h"

namespace cloudcontact::testing::triangle_slide_test {
namespace {

class TriangleSlide : public ::testing::TestWithParam<const char*> {};

TEST_P(TriangleSlide, NoInnerEdgeStopsAndFlatPartsAreFlat) {
  const Slider slider = sliderOf(GetParam());
  CloudBody cloud(slider.mesh, at({0, 0, 0}), {.voxelSize = 0.005});
  const std::vector<Vec3> vertices = verticesOf(slider, cloud);
  for (Course& course : terrains()) {
    SCOPED_TRACE(slider.name + " on " + course.name);
    CourseWorld world(course);
    world.start(cloud.body(), vertices);
    const Slide s = slide(world, cloud.body(), vertices);
    ASSERT_LT(s.steps, kMostSteps) << "it did not come to the end";
    EXPECT_NEAR(s.bumps / s.start, 1, 2e-3);
    EXPECT_NEAR(s.end / s.flat, 1, 2e-3);
    EXPECT_GT(s.slowest / s.start, 0.9);
    // On the way the spring gives what it held at the start, and a step's motion in curves counts
    // twice: together up to 0.4 %.
    const double moving = 0.5 * s.weight / 9.81 * kCourseSpeed * kCourseSpeed;
    EXPECT_LT(s.gained, 5e-3 * moving);
    EXPECT_LT(s.ended, 0);
    EXPECT_LT(s.deepest, 0.005);
    EXPECT_EQ(world.clouds.statistics().failures, 0u) << world.clouds.statistics().lastFailure;
  }
}

INSTANTIATE_TEST_SUITE_P(Bodies, TriangleSlide,
                         ::testing::Values("box", "ball", "cup", "nut", "cow"),
                         [](const auto& made) { return std::string(made.param); });

}  // namespace
}  // namespace cloudcontact::testing::triangle_slide_test
