// Contacts of clouds against closed forms: normal, depth, centre of force and force of every case
// in contact_cases.cpp, pressed 0.3 to 1 voxel, each at its own random grids, poses and place.
#include <cloudcontact/mesh/mesh_repair.h>

#include <gtest/gtest.h>

#include <cmath>

#include "contact/contact_cases.h"

namespace cloudcontact::testing {
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
    EXPECT_LE(s.worst.centre, one.bounds.centre) << "voxels from the true centre to the axis";
    EXPECT_LE(s.worst.forceRelative, one.bounds.forceRelative) << "of the force k d";
  }
}

// Cases of which something is asked: the others are for the table.
std::vector<ContactCase> boundedCases() {
  std::vector<ContactCase> cases = contactCases();
  std::erase_if(cases, [](const ContactCase& one) { return std::isinf(one.bounds.normalDeg); });
  return cases;
}

std::string nameOf(const ::testing::TestParamInfo<ContactCase>& param) {
  return testName(param.param.name);
}

INSTANTIATE_TEST_SUITE_P(Cases, ContactAccuracy, ::testing::ValuesIn(boundedCases()), nameOf);

// The cases' own ground: meshes that are not the solids they stand for would make every figure
// above a lie.
TEST(ContactCaseMeshes, AreTheSolidsTheyStandFor) {
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
}  // namespace cloudcontact::testing
