// `--method paper` with its options, and tissues, in contact and simulate: against closed forms.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "program/obj_file.h"
#include "program/program_run.h"

namespace prog_paper_test {
namespace {

using nlohmann::json;
using program_test::Outcome;
using program_test::Workplace;
using Arguments = std::vector<std::string>;
using Vec = Eigen::Vector3d;

Vec vec(const json& j) {
  return Vec(j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>());
}

Arguments with(Arguments arguments, const Arguments& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

json found(const Workplace& place, const Arguments& arguments) {
  const Outcome outcome = place.run(with(arguments, {"--json"}));
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
  return outcome.json();
}

// A plate of 100 x 100 x 20 voxels, half a voxel deep in the half-space.
const Arguments kPlate = {"contact", "halfspace",  "box:0.1,0.1,0.02", "--voxel", "0.001",
                          "--pose",  "0 0 0.0095", "--repeat",         "1",       "--method",
                          "paper"};

// (1 - a^2)^4 / 8 over the integral of (1 - z^2)^3 from -a to 1: where the matter above a plane at
// -a has its center of gravity in a unit ball with the weight (1 - r^2)^2.
double centerAbovePlane(double a) {
  const auto primitive = [](double z) {
    return z - std::pow(z, 3) + 3 * std::pow(z, 5) / 5 - std::pow(z, 7) / 7;
  };
  return std::pow(1 - a * a, 4) / 8 / (primitive(1) + primitive(a));
}

// Each collision voxel's center lies half a voxel above the plate's lower face, so the length of
// its base vector is known. Gr aside then tilts the force by a known angle.
TEST(PaperOptions, WindowAndRepresentativePointTiltTheForce) {
  const Workplace place;
  for (const auto& [window, radius] : {std::pair("sphere:0.003", 3.0), {"sphere:0.004", 4.0}}) {
    const double length = 1e-3 * radius * centerAbovePlane(0.5 / radius);
    for (const double aside : {0.0005, -0.001}) {
      const json result = found(place, with(kPlate, {"--window", window, "--representative",
                                                     std::to_string(aside) + " 0 0"}));
      EXPECT_EQ(result["method"], "paper");
      const Vec force = vec(result["force"]);
      EXPECT_NEAR(force.x() / force.z(), -aside / length, 0.03 * std::abs(aside) / length)
          << window;
      EXPECT_NEAR(force.y() / force.z(), 0, 1e-3);
      EXPECT_NEAR(force.norm(), 1e4 * 0.0005, 0.03 * 5) << "FR does not depend on the direction";
    }
  }
}

// One engine: to the bit.
TEST(PaperOptions, NothingStatedIsTheCloud) {
  const Workplace place;
  const Arguments tilted = {
      "contact", "box:0.02,0.03,0.01", "sphere:0.012", "--voxel", "0.001", "--repeat", "1",
      "--pose",  "0.004 0.002 0.0162"};
  json cloud = found(place, tilted), paper = found(place, with(tilted, {"--method", "paper"}));
  ASSERT_FALSE(cloud["contacts"].empty());
  for (const char* of : {"contacts", "force", "torque", "samples"}) EXPECT_EQ(cloud[of], paper[of]);
  const json stated = found(place, with(tilted, {"--method", "paper", "--membership", "whole"}));
  EXPECT_NE(cloud["force"], stated["force"]);
}

// A long ellipsoid sees farther along its axis: there the base vectors are longer.
TEST(PaperOptions, WindowsHaveTheirOwnAxes) {
  const Workplace place;
  const auto tilt = [&](const char* window) {
    const Vec force = vec(found(
        place, with(kPlate, {"--window", window, "--representative", "0.0005 0 0"}))["force"]);
    return -force.x() / force.z();
  };
  // Full lengths: the sphere of radius 3 voxels is the ellipsoid of 6.
  EXPECT_NEAR(tilt("ellipsoid:0.006,0.006,0.006"), tilt("sphere:0.003"), 1e-9);
  EXPECT_LT(tilt("ellipsoid:0.006,0.006,0.012"), 0.5 * tilt("sphere:0.003"));
  EXPECT_NEAR(tilt("ellipsoid:0.012,0.006,0.006") / tilt("sphere:0.003"), 1, 0.1);
  EXPECT_LT(tilt("box:0.003,0.003,0.012"), 0.7 * tilt("box:0.003,0.003,0.006"));
}

// Two tissues of equal density; the first is four times as stiff and eight times as hard.
constexpr const char* kTable = R"([
  {"name": "steel", "stiffness": 40000, "damping": 0, "hardness": 8e9, "density": 1000},
  {"name": "rubber", "stiffness": 10000, "damping": 0, "hardness": 1e9, "density": 1000}])";

// A box as a mesh, off the grid of its voxels by its own place.
cloudcontact::NamedMesh boxPart(const char* name, const Vec& low, const Vec& high) {
  cloudcontact::Mesh mesh;
  for (int k = 0; k < 8; ++k)
    mesh.vertices.emplace_back(k & 4 ? high.x() : low.x(), k & 2 ? high.y() : low.y(),
                               k & 1 ? high.z() : low.z());
  for (const char* face :
       {"013", "032", "467", "475", "045", "051", "237", "276", "026", "064", "157", "173"})
    mesh.triangles.emplace_back(face[0] - '0', face[1] - '0', face[2] - '0');
  return {name, mesh};
}

// A block with its top at z = 0: steel where x < 0, rubber beyond.
void writeSeam(const Workplace& place) {
  place.write("tissues.json", kTable);
  place.write("seam.obj",
              program_test::objText({boxPart("left", Vec(-0.02, -0.02, -0.02), Vec(0, 0.02, 0)),
                                     boxPart("right", Vec(0, -0.02, -0.02), Vec(0.02, 0.02, 0))}));
}

const Arguments kOnSeam = {"contact",    "seam.obj",  "box:0.02,0.02,0.01", "--voxel",
                           "0.001",      "--pose",    "0 0 0.0046",         "--repeat",
                           "1",          "--tissues", "tissues.json",       "--tissue",
                           "left=steel", "--tissue",  "right=rubber"};

double stiffnessOf(const json& result) {
  double k = 0;
  for (const json& c : result["contacts"]) k += c["stiffness"].get<double>();
  return k;
}

// (1): a box across the seam touches as much steel as rubber.
TEST(Tissues, StiffnessIsTheMeanOfWhatIsTouched) {
  const Workplace place;
  writeSeam(place);
  for (const char* method : {"cloud", "paper"}) {
    const json result = found(place, with(kOnSeam, {"--method", method}));
    EXPECT_NEAR(stiffnessOf(result), 25000, 250) << method;
    EXPECT_NEAR(vec(result["force"]).z(), 25000 * 0.0004, 0.3) << method;
  }
  // Both bodies' tissues act in series: the box is rubber.
  const json both = found(place, with(kOnSeam, {"--tissue", "all=rubber"}));
  EXPECT_NEAR(stiffnessOf(both), 25000.0 * 10000 / 35000, 75);
}

// Only the voxels of A in the D of B count: the half of B over the steel.
TEST(Tissues, TheDetectionAreaChoosesWhatIsTouched) {
  const Workplace place;
  writeSeam(place);
  place.write("half.obj", program_test::objText(
                              {boxPart("d", Vec(-0.01, -0.01, -0.005), Vec(-0.001, 0.01, 0.005))}));
  const json whole =
      found(place, with(kOnSeam, {"--method", "paper", "--area-b", "box:0.02,0.02,0.01"}));
  EXPECT_NEAR(stiffnessOf(whole), 25000, 250) << "D is all of the box";
  const json half = found(place, with(kOnSeam, {"--method", "paper", "--area-b", "half.obj"}));
  EXPECT_NEAR(stiffnessOf(half), 40000, 400) << "D is a body from a file, over the steel";
}

// (5'): B lies in a corner of two walls of A. Each wall's force grows with its base vectors, those
// of A times h and those of B; both sides count as many voxels.
TEST(PaperOptions, HardnessBendsTheForce) {
  const Workplace place;
  place.write("tissues.json", kTable);
  place.write("walls.obj", program_test::objText(
                               {boxPart("steel", Vec(-0.01, 0.01, -0.02), Vec(0, 0.03, 0.02)),
                                boxPart("rubber", Vec(0.01, -0.01, -0.02), Vec(0.03, 0, 0.02))}));
  const Arguments cornered = {
      "contact", "walls.obj",       "box:0.04,0.04,0.02", "--voxel", "0.001",
      "--pose",  "0.0195 0.0195 0", "--repeat",           "1",       "--method",
      "paper",   "--tissues",       "tissues.json"};
  const auto imbalance = [&](const Arguments& arguments) {
    const Vec force = vec(found(place, arguments)["force"]);
    return (force.x() - force.y()) / (force.x() + force.y());
  };
  EXPECT_NEAR(imbalance(with(cornered, {"--window", "sphere:0.0025"})), 0, 1e-3)
      << "h does not count";
  EXPECT_NEAR(imbalance(with(cornered, {"--hardness"})), (1 - 0.125) / (1 + 0.125 + 2), 0.02);
}

TEST(PaperOptions, TheCpuTakesThePlaceOfADevice) {
  const Workplace place;
  const Outcome outcome =
      place.run(with(kPlate, {"--window", "sphere:0.0025", "--backend", "opencl", "--json"}));
  EXPECT_EQ(outcome.exitCode, 0);
  EXPECT_NE(outcome.err.find("--backend opencl: stated base vectors"), std::string::npos)
      << outcome.err;
  EXPECT_EQ(outcome.json()["backend"], "cpu");
}

// A block of `mesh` or of `box` on a plane, with gravity 10.
std::string restingOn(const std::string& geometry) {
  return "<?xml version='1.0'?><sdf version='1.9'><world name='w'><gravity>0 0 -10</gravity>"
         "<physics name='p' type='bullet'><max_step_size>0.002</max_step_size></physics>"
         "<model name='floor'><static>true</static><link name='l'><collision name='c'><geometry>"
         "<plane><normal>0 0 1</normal></plane></geometry></collision></link></model>"
         "<model name='block'><pose>0 0 0.02 0 0 0</pose><link name='l'><inertial><mass>1</mass>"
         "</inertial><collision name='c'><geometry>" +
         geometry + "</geometry></collision></link></model></world></sdf>";
}

// It sinks by m g / k, and k is that of the tissues under it.
TEST(Tissues, ABlockSinksByItsTissues) {
  const Workplace place;
  place.write("damped.json", R"([
    {"name": "steel", "stiffness": 40000, "damping": 100, "hardness": 8e9, "density": 1000},
    {"name": "rubber", "stiffness": 10000, "damping": 100, "hardness": 1e9, "density": 1000}])");
  place.write("two.obj",
              program_test::objText({boxPart("steel", Vec(-0.1, -0.1, -0.02), Vec(0.1, 0, 0.02)),
                                     boxPart("rubber", Vec(-0.1, 0, -0.02), Vec(0.1, 0.1, 0.02))}));
  place.write("two.sdf", restingOn("<mesh><uri>two.obj</uri></mesh>"));
  place.write("one.sdf", restingOn("<box><size>0.2 0.2 0.04</size></box>"));
  const auto sag = [&](const Arguments& scene) {
    const json result = found(
        place, with(scene, {"--voxel", "0.004", "--seconds", "1", "--tissues", "damped.json"}));
    return 0.02 - result["bodies"][1]["position"][2].get<double>();
  };
  for (const char* method : {"cloud", "paper"}) {
    SCOPED_TRACE(method);
    EXPECT_NEAR(sag({"simulate", "one.sdf", "--tissue", "all=rubber", "--method", method}),
                10 / 10000.0, 2e-5);
  }
  // By the paper a pair has one k, the mean; its two halves lean to the softer side otherwise.
  EXPECT_NEAR(sag({"simulate", "two.sdf", "--method", "paper", "--window", "sphere:0.01"}),
              10 / 25000.0, 2e-5);
}

TEST(PaperOptions, SimulateRunsByThePaper) {
  const Workplace place;
  place.write("one.sdf", restingOn("<box><size>0.2 0.2 0.04</size></box>"));
  const Arguments scene = {"simulate", "one.sdf", "--voxel", "0.004", "--seconds", "0.2"};
  const json cloud = found(place, scene);
  const json paper = found(place, with(scene, {"--method", "paper"}));
  EXPECT_EQ(paper["method"], "paper");
  EXPECT_NEAR(paper["bodies"][1]["position"][2].get<double>(),
              cloud["bodies"][1]["position"][2].get<double>(), 2e-5);
  // With Gr far aside every force points along x.
  const auto x = [](const json& result) {
    return result["bodies"][1]["position"][0].get<double>();
  };
  EXPECT_LT(std::abs(x(paper)), 1e-4);
  EXPECT_LT(x(found(place, with(scene, {"--method", "paper", "--representative", "1 0 0"}))),
            -0.01);
}

}  // namespace

}  // namespace prog_paper_test
