// CT volumes as bodies of commands and scenes: a ball written as a scan has the mass, the contacts
// and the tissues of a ball.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <sstream>

#include "io/errors.h"
#include "program/program_run.h"
#include "scene/scene_file.h"
#include "scene/scene_shapes.h"

namespace cloudcontact::program::sim_volume_test {
namespace {

using program_test::Outcome;
using program_test::Workplace;

constexpr double kRadius = 8, kInner = 4;  // [mm]
const Vec3 kMiddle(10, 11, 9);             // [mm]
const Vec3 kCore(11.5, 11, 9);             // [mm] of a denser ball inside
constexpr double kAir = -1000, kSoft = 1000, kHard = 2500, kSpacing = 0.5;

// Each value is the mean over its cell.
std::string scan() {
  std::string bytes;
  for (int k = 0; k < 40 * 44 * 36; ++k) {
    const Vec3 corner(k % 40, k / 40 % 44, k / 1760);
    double sum = 0;
    for (int p = 0; p < 512; ++p) {
      const Vec3 at = kSpacing * (corner + Vec3(p % 8 + .5, p / 8 % 8 + .5, p / 64 + .5) / 8);
      const bool isIn = (at - kMiddle).norm() < kRadius, isHard = (at - kCore).norm() < kInner;
      sum += !isIn ? kAir : isHard ? kHard : kSoft;
    }
    const auto value = static_cast<std::int16_t>(std::lround(sum / 512));
    bytes += static_cast<char>(value & 255);
    bytes += static_cast<char>(value >> 8);
  }
  return bytes;
}

class Volume : public ::testing::Test {
 protected:
  Volume() {
    static const std::string bytes = scan();
    place_.write("ball.raw", bytes);
    place_.write("ball.mhd",
                 "ObjectType = Image\nNDims = 3\nDimSize = 40 44 36\nElementType = MET_SHORT\n"
                 "ElementSpacing = 0.5 0.5 0.5\nOffset = 0.25 0.25 0.25\n"
                 "ElementDataFile = ball.raw\n");
  }

  // A scene with one ball, with these elements in its collision.
  SceneDescription scene(const std::string& elements, const std::string& rest = "",
                         const std::string& geometry = "<mesh><uri>ball.mhd</uri></mesh>") const {
    place_.write("s.sdf",
                 "<sdf version='1.9' xmlns:cloudcontact='urn:cloudcontact'><world name='w'>"
                 "<model name='ball'><pose>0 0 0 0 0 0</pose><link name='l'><collision name='c'>"
                 "<geometry>" +
                     geometry + "</geometry>" + elements + "</collision></link></model>" + rest +
                     "</world></sdf>");
    return loadScene((place_ / "s.sdf").string());
  }
  BodyParts shapes(const SceneDescription& scene) const {
    CommonOptions options;
    options.threads = 1;
    options.metersPerUnit = 1e-3;
    return SceneShapes(options, 5e-4).make(scene.bodies[0]);
  }
  std::string fault(const std::string& elements,
                    const std::string& geometry = "<mesh><uri>ball.mhd</uri></mesh>") const {
    try {
      shapes(scene(elements, "", geometry));
    } catch (const BadInput& error) {
      return error.what();
    }
    return "accepted";
  }

  Workplace place_;
};

double ballVolume(double radius) {
  return 4 / 3.0 * std::numbers::pi * std::pow(1e-3 * radius, 3);
}

TEST_F(Volume, AThresholdMakesABallOfWater) {
  const BodyParts parts = shapes(scene("<cloudcontact:threshold>0</cloudcontact:threshold>"));
  const double mass = 1000 * ballVolume(kRadius), moment = 0.4 * mass * 64e-6;
  EXPECT_NEAR(parts.mass, mass, 1e-3 * mass);
  EXPECT_LT((parts.frame.position - 1e-3 * kMiddle).norm(), 1e-3 * kSpacing * 1e-2);
  EXPECT_LT((parts.inertia - Vec3::Constant(moment)).cwiseAbs().maxCoeff(), 2e-3 * moment);
}

// Mass and its center by the two balls' formulas: grey values pick the tissues.
TEST_F(Volume, RangesAreTissues) {
  const BodyParts parts =
      shapes(scene("<cloudcontact:tissue from='1800'>enamel</cloudcontact:tissue>"
                   "<cloudcontact:tissue from='0'>pulp</cloudcontact:tissue>"));
  const TissueTable table = dentalTissues();
  const auto density = [&](const std::string& name) {
    for (const Tissue& tissue : table)
      if (tissue.name == name) return tissue.density;
    throw std::out_of_range(name);
  };
  const double core = ballVolume(kInner) * (density("enamel") - density("pulp"));
  const double mass = ballVolume(kRadius) * density("pulp") + core;
  EXPECT_NEAR(parts.mass, mass, 5e-3 * mass);
  const Vec3 center = 1e-3 * (kMiddle + core / mass * (kCore - kMiddle));
  EXPECT_LT((parts.frame.position - center).norm(), 0.02 * (center - 1e-3 * kMiddle).norm());
}

TEST_F(Volume, OneRangeIsTheTissueOfAll) {
  const BodyParts parts =
      shapes(scene("<cloudcontact:tissue from='0'>enamel</cloudcontact:tissue>"));
  const double mass = dentalTissues()[0].density * ballVolume(kRadius);
  ASSERT_EQ(dentalTissues()[0].name, "enamel");
  EXPECT_NEAR(parts.mass, mass, 1e-3 * mass);
}

TEST_F(Volume, WrongElementsAreRefused) {
  const auto expect = [&](const std::string& found, const std::string& says) {
    EXPECT_NE(found.find(says), std::string::npos) << found << "\n  lacks: " << says;
  };
  const std::string tissue = "<cloudcontact:tissue from='0'>pulp</cloudcontact:tissue>";
  const std::string threshold = "<cloudcontact:threshold>0</cloudcontact:threshold>";
  const std::string box = "<box><size>1 1 1</size></box>";
  expect(fault(""), "from -1000 to 2500; say from which value on");
  expect(fault(tissue, box), "are those of a volume");
  expect(fault(threshold, box), "are those of a volume");
  expect(fault(tissue + threshold), "leave one out");
  expect(fault(threshold + threshold), "twice");
  expect(fault("<cloudcontact:threshold>air</cloudcontact:threshold>"), "threshold>");
  expect(fault("<cloudcontact:threshold>9000</cloudcontact:threshold>"), "nothing but air");
  expect(fault(tissue + "<cloudcontact:tissue>enamel</cloudcontact:tissue>"), "add from");
  expect(fault(tissue + "<cloudcontact:tissue from='0'>enamel</cloudcontact:tissue>"), "one value");
  expect(fault("<cloudcontact:tissue part='a' from='0'>pulp</cloudcontact:tissue>"),
         "part and from");
  expect(fault("<cloudcontact:tissue from='0'>wax</cloudcontact:tissue>"), "wax");
  place_.write("ball.raw", "short");
  expect(fault(threshold), "cut short");
}

// It falls on the floor and lies on it: the middle stands a radius above.
TEST_F(Volume, SimulateDropsIt) {
  scene("<cloudcontact:threshold>0</cloudcontact:threshold>",
        "<model name='floor'><static>true</static><pose>0 0 -0.001 0 0 0</pose><link name='l'>"
        "<collision name='c'><geometry><plane><normal>0 0 1</normal></plane></geometry>"
        "</collision></link></model>");
  const Outcome run = place_.run({"simulate", "s.sdf", "--unit", "mm", "--seconds", "1", "--step",
                                  "0.002", "--threads", "1", "--json"});
  ASSERT_EQ(run.exitCode, 0) << run.err;
  const auto body = run.json()["bodies"][0];
  const auto& q = body["orientation"];
  const Eigen::Quaterniond turn(q[3].get<double>(), q[0].get<double>(), q[1].get<double>(),
                                q[2].get<double>());
  const double middle = body["position"][2].get<double>() + (turn * (1e-3 * kMiddle)).z();
  EXPECT_NEAR(middle, 1e-3 * (kRadius - 1), 0.2e-3 * kSpacing) << run.out;
}

TEST_F(Volume, ContactPressesTheBall) {
  const Outcome run = place_.run({"contact", "ball.mhd", "box:0.03,0.03,0.01", "--pose",
                                  "0.01 0.011 0.0215", "--threshold", "0", "--unit", "mm",
                                  "--stiffness", "1000", "--voxel", "0.0005", "--json"});
  ASSERT_EQ(run.exitCode, 0) << run.err;
  // The box's face is half a millimeter below the ball's top.
  EXPECT_NEAR(run.json()["force"][2].get<double>(), 0.5, 0.01);
}

TEST_F(Volume, DrillCutsItsTissues) {
  const Outcome run =
      place_.run({"drill", "ball.mhd", "--unit", "mm", "--threshold", "pulp=0", "--threshold",
                  "enamel=1800", "--bur", "sphere:0.0024", "--seconds", "0.1", "--json"});
  ASSERT_EQ(run.exitCode, 0) << run.err;
  EXPECT_NE(run.out.find("pulp"), std::string::npos) << run.out;
}

TEST_F(Volume, UnusedThresholdsAreRefused) {
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"digitize", "sphere:0.1", "--threshold", "0"},
           {"digitize", "ball.mhd", "--threshold", "0", "--threshold", "a=1"},
           {"digitize", "ball.mhd", "--threshold", "a=0", "--threshold", "b=0"},
           {"digitize", "ball.mhd", "--threshold", "bone"}}) {
    const Outcome run = place_.run(arguments);
    EXPECT_EQ(run.exitCode, 2);
    EXPECT_NE(run.err.find("--threshold"), std::string::npos) << run.err;
  }
}

}  // namespace
}  // namespace cloudcontact::program::sim_volume_test
