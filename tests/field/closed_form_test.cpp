// Closed forms in the place of fields: which clouds have one, and where lines pass it.
#include "field/closed_form.h"

#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/voxels/digitize.h>
#include <gtest/gtest.h>

#include <numbers>

#include "contact/contact_cases.h"
#include "field/field_ray.h"
#include "field/mesh_field.h"
#include "law/hulls.h"
#include "mesh/thread_meshes.h"
#include "workpiece/cut_cases.h"

namespace cloudcontact::testing::closed_form_test {
namespace {

// Rays through a ball, a box and a hexagonal block pass where the solids' depth is zero, in order,
// and never behind their ends.
TEST(ClosedForm, RaysPassItWhereItsDepthIsZero) {
  Random random(11);
  int passed = 0, missed = 0, within = 0;
  for (const Mesh& mesh : {sphereMesh(0.3, 1e-4), boxMesh({0.6, 0.5, 0.4}),
                           test::meshOf(test::prismHull(6, 0.25, 0.3))}) {
    const auto field = fieldOf(mesh, 0.02);
    const PlacedSolid& form = closedForm(*field)->placed;
    for (int i = 0; i < 300; ++i) {
      const Vec3 from = 0.8 * (random.inCube() - Vec3(0.5, 0.5, 0.5)),
                 to = 0.8 * (random.inCube() - Vec3(0.5, 0.5, 0.5));
      const bool begins = depthOf(form, from) > 0, ends = depthOf(form, to) > 0;
      bool in = begins;
      double before = 0;
      visitCrossings(*field, from, to, 1, [&](const FieldHit& hit, bool enters) {
        EXPECT_NE(enters, in) << i;
        EXPECT_GE(hit.fraction, before) << i;
        EXPECT_NEAR(depthOf(form, from + hit.fraction * (to - from)), 0, 1e-9) << i;
        EXPECT_EQ(hit.normal.dot(to - from) < 0, enters) << i;
        before = hit.fraction;
        in = enters;
        ++passed;
        return true;
      });
      EXPECT_EQ(in, ends) << i;
      missed += before == 0 && !begins;
      within += begins && ends;
    }
  }
  EXPECT_GT(passed, 100);
  EXPECT_GT(missed, 50);
  EXPECT_GT(within, 10);
}

TEST(ClosedForm, BallsAndBoxesHaveOneToriAndWhatWasCutHaveNone) {
  const auto ball = fieldOf(sphereMesh(0.3, 1e-4), 0.02);
  const RecognizedShape* const form = closedForm(*ball);
  ASSERT_TRUE(form);
  ASSERT_TRUE(std::holds_alternative<Sphere>(form->placed.solid));
  EXPECT_NEAR(std::get<Sphere>(form->placed.solid).radius, 0.3, 0.002);
  EXPECT_TRUE(closedForm(*fieldOf(boxMesh({0.6, 0.5, 0.4}), 0.02)));
  const auto block = fieldOf(test::meshOf(test::prismHull(6, 0.25, 0.3)), 0.02);
  ASSERT_TRUE(closedForm(*block));
  EXPECT_TRUE(std::holds_alternative<Hull>(closedForm(*block)->placed.solid));
  const Mesh torus = revolvedMesh(96, 48, true, [](double angle, double along) {
    const double turn = 2 * std::numbers::pi * along, r = 0.3 + 0.1 * std::cos(turn);
    return Vec3(r * std::cos(angle), r * std::sin(angle), 0.1 * std::sin(turn));
  });
  EXPECT_FALSE(closedForm(*fieldOf(torus, 0.02)));
  // A cut is seen, and no tick of a cutting loop waits for a fit.
  FieldSettings settings;
  settings.renewable = true;
  DigitizeSettings digitizing;
  digitizing.voxelSize = 0.02;
  const Cloud cloud = digitize(boxMesh({0.6, 0.5, 0.4}), digitizing);
  const auto whole = SurfaceField::build(cloud, settings);
  EXPECT_TRUE(closedForm(*whole));
  const auto cut = renewed(whole, cutCloud(cloud, bite(cloud, Vec3(4, 4, 4), 3)), settings);
  EXPECT_FALSE(closedForm(*cut));
}

}  // namespace
}  // namespace cloudcontact::testing::closed_form_test
