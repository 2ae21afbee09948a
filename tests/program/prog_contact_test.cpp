// `cloudcontact contact`: the names in its JSON, and known forces.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "program/program_run.h"

namespace prog_contact_test {
namespace {

using nlohmann::json;
using program_test::Outcome;
using program_test::Workplace;
using Vec = Eigen::Vector3d;

Vec vec(const json& j) {
  return Vec(j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>());
}

json contact(std::vector<std::string> rest) {
  const Workplace place;
  rest.insert(rest.begin(), "contact");
  rest.insert(rest.end(), {"--json", "--repeat", "2"});
  const Outcome outcome = place.run(rest);
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");  // a posed pair is no faulty world: no advice
  return outcome.json();
}

// A sphere of 20 voxels, half a voxel deep in the half-space.
const std::vector<std::string> kSphereOnPlane = {"halfspace", "sphere:0.02", "--voxel",
                                                 "0.001",     "--pose",      "0.1 0.2 0.0195"};

std::vector<std::string> with(std::vector<std::string> arguments,
                              const std::vector<std::string>& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(Contact, HasTheDocumentedNames) {
  const json result = contact(kSphereOnPlane);
  EXPECT_EQ(result.at("method"), "cloud");
  EXPECT_EQ(result.at("backend"), "cpu");
  EXPECT_EQ(result.at("force").size(), 3U);
  EXPECT_EQ(result.at("torque").size(), 3U);
  EXPECT_TRUE(result.at("patches").is_number_unsigned());
  EXPECT_TRUE(result.at("samples").is_number_unsigned());
  EXPECT_TRUE(result.at("microseconds").at("median").is_number());
  EXPECT_TRUE(result.at("microseconds").at("p99").is_number());
  ASSERT_FALSE(result.at("contacts").empty());
  for (const json& c : result["contacts"]) {
    EXPECT_EQ(c.at("position").size(), 3U);
    EXPECT_EQ(c.at("normal").size(), 3U);
    for (const char* name : {"depth", "stiffness", "damping", "patch", "confidence"})
      EXPECT_TRUE(c.at(name).is_number()) << name;
  }
}

// k d upward, and the torque of that force about the world's origin, for every method that supports
// it.
TEST(Contact, ASphereOnAPlaneIsPushedOutByItsStiffnessTimesItsDepth) {
  for (const char* method : {"cloud", "paper", "primitive", "gjk"}) {
    SCOPED_TRACE(method);
    const json result = contact(with(kSphereOnPlane, {"--method", method, "--stiffness", "3000"}));
    const double truth = 3000 * 0.0005;
    const Vec force = vec(result["force"]);
    EXPECT_NEAR(force.z() / truth, 1, 0.03);
    EXPECT_LT(force.head<2>().norm(), 0.01 * truth);
    const Vec torque = vec(result["torque"]), lever(0.1, 0.2, 0);
    EXPECT_LT((torque - lever.cross(force)).norm(), 0.002 * truth);
    for (const json& c : result["contacts"]) EXPECT_GT(vec(c["normal"]).z(), 0.99);
  }
}

TEST(Contact, GimpactFindsABoxInAPlane) {
  const json result = contact({"halfspace", "box:0.02,0.02,0.02", "--voxel", "0.001", "--pose",
                               "0 0 0.0095", "--method", "gimpact"});
  EXPECT_NEAR(vec(result["force"]).z() / (1e4 * 0.0005), 1, 0.05);
  EXPECT_EQ(result["contacts"].size(), 4U);
}

// Exchanging A and B reverses the force.
TEST(Contact, NormalsPointFromAToBInEitherOrder) {
  for (const char* method : {"cloud", "paper", "primitive", "gjk", "gimpact", "hacd"}) {
    SCOPED_TRACE(method);
    const json up = contact({"halfspace", "box:0.02,0.02,0.02", "--voxel", "0.001", "--pose",
                             "0 0 0.0095", "--method", method});
    const json down = contact({"box:0.02,0.02,0.02", "halfspace", "--voxel", "0.001", "--pose",
                               "0 0 -0.0095", "--method", method});
    EXPECT_GT(vec(up["force"]).z(), 0);
    EXPECT_NEAR(vec(up["force"]).z() / -vec(down["force"]).z(), 1, 1e-3);
    // GImpact against a plane puts its points on one surface: half a depth off.
    const double midway = std::string(method) == "gimpact" ? 6e-4 : 1e-4;
    for (const json& c : down["contacts"]) {
      EXPECT_LT(vec(c["normal"]).z(), -0.99);
      EXPECT_NEAR(c["position"][2].get<double>(), -0.00975, midway)
          << "midway between the surfaces";
    }
  }
}

TEST(Contact, DampingResistsApproachAndNeverPulls) {
  for (const char* method : {"cloud", "paper", "primitive"}) {
    SCOPED_TRACE(method);
    const auto force = [&](const char* velocity) {
      return vec(contact(
                     with(kSphereOnPlane, {"--method", method, "--stiffness", "1000", "--damping",
                                           "20", "--velocity", velocity}))["force"])
          .z();
    };
    const double still = force("0 0 0 0 0 0");
    EXPECT_NEAR(still, 0.5, 0.02);
    EXPECT_NEAR(force("0 0 -0.01 0 0 0") - still, 20 * 0.01, 0.01);
    EXPECT_NEAR(force("0 0 0.01 0 0 0") - still, -20 * 0.01, 0.01);
    EXPECT_NEAR(force("0 0 1 0 0 0"), 0, 1e-9) << "separating fast: no tension";
    EXPECT_NEAR(force("3 0 0 0 0 0") - still, 0, 0.02) << "sliding along";
    // Rotation about the sphere's center moves no surface point along its normal.
    EXPECT_NEAR(force("0 0 0 10 0 0") - still, 0, 0.02);
  }
}

TEST(Contact, ApartIsAnEmptyResult) {
  for (const char* method : {"cloud", "paper", "primitive", "gjk", "gimpact"}) {
    const json result = contact(
        {"halfspace", "sphere:0.02", "--voxel", "0.001", "--pose", "0 0 0.03", "--method", method});
    EXPECT_TRUE(result["contacts"].empty()) << method;
    EXPECT_EQ(vec(result["force"]), Vec::Zero());
  }
}

// Archimedes: under the foundation law the force is k times the volume under the plane.
TEST(Contact, FoundationWeighsTheOverlap) {
  const json result = contact({"halfspace", "box:0.02,0.03,0.02", "--voxel", "0.0005", "--pose",
                               "0 0 0.0097", "--law", "foundation", "--stiffness", "1e8"});
  EXPECT_NEAR(vec(result["force"]).z() / (1e8 * 0.02 * 0.03 * 0.0003), 1, 0.03);
}

// A primitive and a mesh file of the same box give the same contact.
TEST(Contact, APrimitiveIsTheSameAsItsMesh) {
  const Workplace place;
  std::string obj;
  for (int k = 0; k < 8; ++k)
    obj += std::string("v ") + (k & 1 ? "10" : "-10") + (k & 2 ? " 10" : " -10") +
           (k & 4 ? " 10\n" : " -10\n");
  obj += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
  place.write("box.obj", obj);
  const auto force = [&](const std::string& body) {
    const Outcome outcome =
        place.run({"contact", "halfspace", body, "--unit", "mm", "--voxel", "0.001", "--pose",
                   "0 0 0.0095 0 0 0.38268343236508977 0.9238795325112867", "--json"});
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    return vec(outcome.json()["force"]);
  };
  EXPECT_LT((force("box.obj") - force("box:0.02,0.02,0.02")).norm(), 1e-4 * 5);
}

TEST(Contact, FallsBackToTheCpuWithAMessage) {
  const Workplace place;
  const Outcome outcome =
      place.run({"contact", "sphere:0.02", "sphere:0.02", "--voxel", "0.002", "--pose", "0 0 0.039",
                 "--method", "paper", "--window", "sphere:0.01", "--backend", "opencl", "--json"});
  EXPECT_EQ(outcome.exitCode, 0);
  EXPECT_NE(outcome.err.find("--backend opencl: "), std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.json()["backend"], "cpu");
}

// Equal to the last printed digit.
void expectOpenClEqualsTheCpu(const std::string& a, const std::string& b, const std::string& pose) {
  const Workplace place;
  const auto contact = [&](const char* backend) {
    const Outcome outcome = place.run({"contact", a, b, "--voxel", "0.001", "--pose", pose,
                                       "--repeat", "2", "--backend", backend, "--json"});
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    return outcome;
  };
  const Outcome device = contact("opencl"), cpu = contact("cpu");
  const nlohmann::json got = device.json(), want = cpu.json();
  EXPECT_EQ(got["force"], want["force"]);
  EXPECT_EQ(got["contacts"], want["contacts"]);
  EXPECT_EQ(want["backend"], "cpu");
  EXPECT_GT(want["contacts"].size(), 0U);
  if (got["backend"] == "opencl") return;
  EXPECT_NE(device.err.find("install"), std::string::npos) << device.err;
  EXPECT_EQ(std::getenv("CLOUDCONTACT_NEEDS_OPENCL"), nullptr) << device.err;
}

TEST(Contact, OpenClEqualsTheCpu) {
  expectOpenClEqualsTheCpu("sphere:0.02", "sphere:0.01", "0.001 0 0.0291");
  expectOpenClEqualsTheCpu("halfspace", "sphere:0.01", "0 0 0.0095");
}

}  // namespace

}  // namespace prog_contact_test
