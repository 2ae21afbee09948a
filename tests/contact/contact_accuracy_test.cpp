// Contacts of clouds compared with closed forms: normal, depth, force and its center, for every
// case of contact_cases.cpp, pressed by 0.3 to 1 voxel, on random grids and at random poses.
#include <cloudcontact/mesh/mesh_repair.h>

#include <gtest/gtest.h>

#include <cmath>

#include "contact/contact_cases.h"

namespace cloudcontact::testing::contact_accuracy_test {
namespace {

class ContactAccuracy : public ::testing::TestWithParam<ContactCase> {};

TEST_P(ContactAccuracy, KeepsItsBounds) {
  const ContactCase& one = GetParam();
  RunSettings settings;
  settings.instances = 3;
  const auto summaries = runCase(one, one.depths, settings);
  for (std::size_t k = 0; k < summaries.size(); ++k) {
    SCOPED_TRACE("pressed by " + std::to_string(one.depths[k]) + " voxels");
    const ErrorSummary& s = summaries[k];
    EXPECT_EQ(s.missed, 0) << "contacts not found";
    EXPECT_LE(s.worst.normalDeg, one.bounds.normalDeg) << "degrees off the true normal";
    EXPECT_LE(s.worst.depth, one.bounds.depth) << "voxels off the true depth";
    EXPECT_LE(s.worst.center, one.bounds.center) << "voxels from the true center to the axis";
    EXPECT_LE(s.worst.forceRelative, one.bounds.forceRelative) << "of the force k d";
  }
}

// Cases with bounds. The others are only printed by contact_table.
std::vector<ContactCase> boundedCases() {
  std::vector<ContactCase> cases = contactCases();
  std::erase_if(cases, [](const ContactCase& one) { return std::isinf(one.bounds.normalDeg); });
  return cases;
}

std::string nameOf(const ::testing::TestParamInfo<ContactCase>& param) {
  return testName(param.param.name);
}

INSTANTIATE_TEST_SUITE_P(Cases, ContactAccuracy, ::testing::ValuesIn(boundedCases()), nameOf);

// All results above rely on meshes that match the ideal solids.
TEST(ContactCaseMeshes, MatchTheIdealSolids) {
  const double tolerance = 0.003;
  const Mesh sphere = sphereMesh(40, tolerance), cylinder = cylinderMesh(24, 36, tolerance);
  for (const Mesh* mesh : {&sphere, &cylinder}) {
    const MeshReport report = inspect(*mesh);
    EXPECT_TRUE(report.closed());
    EXPECT_GT(report.volume, 0) << "turned inside out";
  }
  for (const auto& t : sphere.triangles) {
    const Vec3 middle = (sphere.vertices[t[0]] + sphere.vertices[t[1]] + sphere.vertices[t[2]]) / 3;
    ASSERT_NEAR(middle.norm(), 40, tolerance);
    ASSERT_NEAR(sphere.vertices[t[0]].norm(), 40, tolerance);
  }
  EXPECT_NEAR(inspect(cylinder).volume, 3.14159265358979 * 24 * 24 * 36, 1e-6 * 65144);
  EXPECT_NEAR(inspect(boxMesh({2, 3, 4})).volume, 24, 1e-12);
  EXPECT_NEAR(inspect(boxMesh({2, 3, 4})).area, 52, 1e-12);
}

}  // namespace
}  // namespace cloudcontact::testing::contact_accuracy_test
