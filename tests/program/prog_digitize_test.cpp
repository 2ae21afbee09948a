// `cloudcontact digitize`: the names in its JSON, closed forms, and files read back.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "program/program_run.h"

namespace prog_digitize_test {
namespace {

using nlohmann::json;
using program_test::Outcome;
using program_test::Workplace;

json digitize(const Workplace& place, std::vector<std::string> rest) {
  rest.insert(rest.begin(), "digitize");
  rest.push_back("--json");
  const Outcome outcome = place.run(rest);
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
  return outcome.json();
}

TEST(Digitize, HasTheDocumentedNames) {
  const Workplace place;
  const json result = digitize(place, {"box:0.01,0.02,0.03", "--voxel", "0.001"});
  for (const char* name :
       {"voxelSize", "voxels", "bandVoxels", "volume", "mass", "bytes", "milliseconds"})
    EXPECT_TRUE(result.at(name).is_number()) << name;
  EXPECT_EQ(result.at("centerOfMass").size(), 3U);
  EXPECT_EQ(result.at("inertia").size(), 9U);
  EXPECT_TRUE(result.at("closed").is_boolean());
}

TEST(Digitize, WeighsABoxByItsClosedForm) {
  const Workplace place;
  const double x = 0.0103, y = 0.0207, z = 0.0311;  // no face lies on a voxel's face
  const json result =
      digitize(place, {"box:0.0103,0.0207,0.0311", "--voxel", "0.0005", "--density", "7800"});
  const double mass = 7800 * x * y * z;
  EXPECT_NEAR(result["volume"].get<double>() / (x * y * z), 1, 1e-4);
  EXPECT_NEAR(result["mass"].get<double>() / mass, 1, 1e-4);
  for (const json& c : result["centerOfMass"]) EXPECT_NEAR(c.get<double>(), 0, 1e-6);
  const double inertia[3] = {mass / 12 * (y * y + z * z), mass / 12 * (x * x + z * z),
                             mass / 12 * (x * x + y * y)};
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      EXPECT_NEAR(result["inertia"][3 * row + column].get<double>() / inertia[row],
                  row == column ? 1 : 0, 2e-4);
  EXPECT_TRUE(result["closed"].get<bool>());
}

TEST(Digitize, SphereHasItsVolumeInEveryUnitOfLength) {
  const Workplace place;
  for (const double size : {0.001, 1.0, 100.0}) {
    const std::string radius = std::to_string(0.02 * size), voxel = std::to_string(0.001 * size);
    const json result = digitize(place, {"sphere:" + radius, "--voxel", voxel});
    const double r = 0.02 * size;
    EXPECT_NEAR(result["volume"].get<double>() / (4 * std::numbers::pi / 3 * r * r * r), 1, 2e-3);
  }
}

TEST(Digitize, ReadsFilesInTheirUnit) {
  const Workplace place;
  // A unit cube's corner cut off: volume 1/6 of a cubic unit.
  place.write("corner.obj",
              "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const std::pair<const char*, double> units[] = {
      {"mm", 0.001}, {"cm", 0.01}, {"in", 0.0254}, {"m", 1}};
  for (const auto& [unit, meters] : units) {
    const json result = digitize(place, {"corner.obj", "--unit", unit});
    EXPECT_NEAR(result["volume"].get<double>() * 6 / std::pow(10 * meters, 3), 1, 1e-3) << unit;
  }
}

TEST(Digitize, ASavedCloudIsReadBackUnchanged) {
  const Workplace place;
  const json made =
      digitize(place, {"cylinder:0.01,0.02", "--voxel", "0.0007", "-o", "kept.cloud"});
  EXPECT_EQ(place.files(), std::set<std::string>{"kept.cloud"});
  const json kept = digitize(place, {"kept.cloud"});
  for (const char* name : {"voxelSize", "voxels", "bandVoxels", "volume", "mass", "centerOfMass",
                           "inertia", "cloudBytes"})
    EXPECT_EQ(made[name], kept[name]) << name;
}

// A square sheet of side 20 mm becomes a plate of the given thickness, with a known volume.
TEST(Digitize, ASheetBecomesAShellAndSaysSo) {
  const Workplace place;
  place.write("sheet.obj", "v 0 0 0\nv 20 0 0\nv 20 20 0\nv 0 20 0\nf 1 2 3\nf 1 3 4\n");
  const Outcome outcome = place.run(
      {"digitize", "sheet.obj", "--unit", "mm", "--voxel", "0.0005", "--shell", "0.002", "--json"});
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("sheet.obj has no inside"), std::string::npos) << outcome.err;
  EXPECT_NEAR(outcome.json()["volume"].get<double>(), 0.02 * 0.02 * 0.002, 1e-9);
  // The faces point up, so the material lies below them.
  EXPECT_NEAR(outcome.json()["centerOfMass"][2].get<double>(), -0.001, 1e-5);
}

TEST(Digitize, WritesNothingButTheResultToStdoutAndNoBarToAFile) {
  const Workplace place;
  const Outcome outcome = place.run({"digitize", "sphere:0.01", "--voxel", "0.0005", "--json"});
  EXPECT_EQ(outcome.err, "");
  EXPECT_NO_THROW(outcome.json());
}

TEST(Digitize, ThreadsChangeNothing) {
  const Workplace place;
  json one = digitize(place, {"cone:0.01,0.02", "--voxel", "0.0005", "--threads", "1"});
  json two = digitize(place, {"cone:0.01,0.02", "--voxel", "0.0005", "--threads", "2"});
  for (json* result : {&one, &two})
    for (const char* time : {"milliseconds", "cloudMilliseconds", "fieldMilliseconds"})
      result->erase(time);
  EXPECT_EQ(one, two);
}

// The cloud files of device and CPU are equal; without a device there is a message.
TEST(Digitize, OpenClEqualsTheCpu) {
  const Workplace place;
  const auto made = [&](const char* backend, const std::string& body) {
    return place.run({"digitize", body, "--voxel", "0.001", "--backend", backend, "-o",
                      std::string(backend) + ".cloud", "--json"});
  };
  const Outcome device = made("opencl", "sphere:0.0123"), cpu = made("cpu", "sphere:0.0123");
  ASSERT_EQ(device.exitCode, 0) << device.err;
  ASSERT_EQ(cpu.exitCode, 0) << cpu.err;
  EXPECT_EQ(place.read("opencl.cloud"), place.read("cpu.cloud"));
  EXPECT_EQ(cpu.json()["backend"], "cpu");
  EXPECT_EQ(cpu.err, "");
  if (device.json()["backend"] == "cpu") {
    EXPECT_NE(device.err.find("install"), std::string::npos) << device.err;
    EXPECT_EQ(std::getenv("CLOUDCONTACT_NEEDS_OPENCL"), nullptr) << device.err;
  }
  const Outcome saved = place.run({"digitize", "cpu.cloud", "--backend", "opencl", "--json"});
  EXPECT_EQ(saved.exitCode, 0);
  EXPECT_NE(saved.err.find("--backend opencl: cpu.cloud is not a mesh"), std::string::npos)
      << saved.err;
  EXPECT_EQ(saved.json()["backend"], "cpu");
}

}  // namespace

}  // namespace prog_digitize_test
