// The commands simulate and demo: the names in their JSON, complete files, and bad input.
#include <cloudcontact/law/tissue.h>
#include <gtest/gtest.h>
#include <CLI/CLI.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "commands/commands.h"
#include "demos/demo.h"

namespace cloudcontact::program::sim_command_test {
namespace {

using Json = nlohmann::json;

constexpr const char* kScene = R"(<?xml version="1.0"?>
<sdf version="1.9"><world name="w"><gravity>0 0 -9.81</gravity>
<physics name="p" type="bullet"><max_step_size>0.005</max_step_size>
<real_time_factor>0</real_time_factor></physics>
<model name="floor"><static>true</static><link name="l"><collision name="c">
<geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model>
<model name="brick"><pose>0 0 0.1 0 0 0</pose><link name="l"><inertial><mass>1</mass></inertial>
<collision name="c"><geometry><box><size>0.2 0.2 0.2</size></box></geometry></collision></link>
</model></world></sdf>)";

class CommandTest : public ::testing::Test {
 protected:
  CommandTest() {
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("cloudcontact_command_") +
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
    std::ofstream(scene()) << kScene;
  }
  ~CommandTest() override { std::filesystem::remove_all(folder_); }

  std::string scene() const { return (folder_ / "scene.sdf").string(); }
  std::string file(const char* name) const { return (folder_ / name).string(); }

  // Runs the command and returns its stdout.
  static std::string run(std::vector<std::string> words) {
    CLI::App app("", "cloudcontact");
    addSimulateCommand(app);
    addDemoCommand(app);
    std::ostringstream out;
    std::streambuf* const kept = std::cout.rdbuf(out.rdbuf());
    std::reverse(words.begin(), words.end());
    try {
      app.parse(words);
    } catch (...) {
      std::cout.rdbuf(kept);
      throw;
    }
    std::cout.rdbuf(kept);
    return out.str();
  }
  static std::string refusal(std::vector<std::string> words) {
    try {
      run(std::move(words));
    } catch (const BadInput& error) {
      return error.what();
    }
    return "accepted";
  }

  std::filesystem::path folder_;
};

// 36 bricks on static ones, each a pair of clouds: a tolerance of 0 asks for voxels.
std::string bricks() {
  std::ostringstream sdf;
  sdf << R"(<?xml version="1.0"?><sdf version="1.9"><world name="w"><gravity>0 0 -9.81</gravity>
<physics name="p" type="bullet"><max_step_size>0.005</max_step_size>
<real_time_factor>0</real_time_factor></physics>)";
  for (int i = 0; i < 72; ++i)
    sdf << "<model name='m" << i << "'><static>" << (i % 2 ? "false" : "true") << "</static><pose>"
        << 0.2 * (i / 2 % 6) << ' ' << 0.2 * (i / 12) << ' ' << (i % 2 ? 0.0999 : 0) << " 0 0 "
        << 0.05 * i << "</pose><link name='l'><collision name='c'><geometry><box><size>0.1 0.1 0.1"
        << "</size></box></geometry><cloudcontact:tolerance>0</cloudcontact:tolerance></collision>"
        << "</link></model>";
  sdf << "</world></sdf>";
  return sdf.str();
}

TEST_F(CommandTest, ADeviceHasTheHashOfTheCpu) {
  std::ofstream(scene()) << bricks();
  const auto simulate = [&](const char* backend) {
    return nlohmann::json::parse(run({"simulate", scene(), "--seconds", "0.1", "--voxel", "0.01",
                                      "--reuse", "0", "--backend", backend, "--json"}));
  };
  ::testing::internal::CaptureStderr();
  const nlohmann::json device = simulate("opencl");
  const std::string said = ::testing::internal::GetCapturedStderr();
  const nlohmann::json cpu = simulate("cpu");
  EXPECT_EQ(device["hash"], cpu["hash"]);
  EXPECT_EQ(cpu["backend"], "cpu");
  EXPECT_FALSE(cpu.contains("device"));
  if (device["backend"] == "opencl") {
    EXPECT_GE(device["device"]["steps"], 20);
    EXPECT_GT(device["device"]["pairs"], 300);
    return;
  }
  EXPECT_NE(said.find("--backend opencl: no OpenCL device; install"), std::string::npos) << said;
  EXPECT_EQ(std::getenv("CLOUDCONTACT_NEEDS_OPENCL"), nullptr) << said;
}

TEST_F(CommandTest, AStepOfFewPairsNeedsNoDevice) {
  ::testing::internal::CaptureStderr();
  run({"simulate", scene(), "--seconds", "0.02", "--voxel", "0.02", "--backend", "opencl"});
  EXPECT_NE(::testing::internal::GetCapturedStderr().find("--backend opencl: "), std::string::npos);
}

TEST_F(CommandTest, ExplainsWhatItModelled) {
  const Json plain = Json::parse(run({"simulate", scene(), "--seconds", "0.5", "--json"}));
  EXPECT_FALSE(plain.contains("explain"));
  const Json asShapes =
      Json::parse(run({"simulate", scene(), "--seconds", "0.5", "--json", "--explain"}));
  EXPECT_EQ(asShapes["hash"], plain["hash"]);
  EXPECT_NE(asShapes["explain"][0]["used"].get<std::string>().find("contacts of"),
            std::string::npos);
  const Json json = Json::parse(run(
      {"simulate", scene(), "--seconds", "0.5", "--json", "--explain", "--tolerance", "exact"}));
  EXPECT_NE(json["hash"], plain["hash"]);
  ASSERT_EQ(json["explain"].size(), 1u);
  const Json& row = json["explain"][0];
  const std::string pair = row["a"].get<std::string>() + row["b"].get<std::string>();
  EXPECT_TRUE(pair == "floorbrick" || pair == "brickfloor") << pair;
  EXPECT_NEAR(row["queries"].get<double>(), 100,
              1);  // contacts are also looked for before the first
  EXPECT_EQ(row["share"], 1);
  EXPECT_GT(row["microseconds"].get<double>(), 0);
  EXPECT_GT(row["expectedError"].get<double>(), 0);
  EXPECT_NE(row["used"].get<std::string>().find("search"), std::string::npos);
  EXPECT_FALSE(row["skipped"].get<std::string>().empty());
  const Json shapes = Json::parse(
      run({"simulate", scene(), "--seconds", "0.5", "--json", "--explain", "--tolerance", "0.01"}));
  EXPECT_NE(shapes["explain"][0]["used"].get<std::string>().find("contacts of"), std::string::npos);
  const std::string text = run({"simulate", scene(), "--seconds", "0.5", "--explain"});
  EXPECT_NE(text.find("left out"), std::string::npos);
}

TEST_F(CommandTest, JsonHasTheDocumentedNames) {
  const auto json = nlohmann::json::parse(
      run({"simulate", scene(), "--seconds", "0.1", "--voxel", "0.02", "--json"}));
  for (const char* name :
       {"method", "steps", "step", "wallSeconds", "realTimeFactor", "narrowPhaseSeconds",
        "solverSeconds", "pairs", "contactsPerStep", "maxPenetration", "energyStart", "energyEnd",
        "energyMax", "hash", "bodies"})
    EXPECT_TRUE(json.contains(name)) << name;
  EXPECT_EQ(json["method"], "cloud");
  EXPECT_EQ(json["steps"], 20);
  EXPECT_EQ(json["step"], 0.005);
  ASSERT_EQ(json["bodies"].size(), 2u);
  const auto& brick = json["bodies"][1];
  EXPECT_EQ(brick["name"], "brick");
  for (const char* name : {"position", "linearVelocity", "angularVelocity", "turns"})
    EXPECT_EQ(brick[name].size(), 3u) << name;
  EXPECT_EQ(brick["orientation"].size(), 4u);
  EXPECT_NEAR(brick["orientation"][3], 1, 1e-3);  // w comes last
  EXPECT_EQ(brick["asleep"], false);
}

// A mill of 4 mm goes into a block that is held; a block of points stands by.
constexpr const char* kMilling = R"(<?xml version="1.0"?>
<sdf version="1.9"><world name="w"><gravity>0 0 0</gravity>
<model name="block"><static>true</static><link name="l"><collision name="c">
<geometry><box><size>0.012 0.008 0.006</size></box></geometry><cloudcontact:cuttable/>
<cloudcontact:tissue part="all">caries</cloudcontact:tissue></collision></link></model>
<model name="mill"><pose>-0.0085 0 0.004 0 0 0</pose><link name="l">
<cloudcontact:drive><linear>0.06 0 0</linear><angular>0 0 300</angular></cloudcontact:drive>
<collision name="c"><geometry><cylinder><radius>0.002</radius><length>0.01</length></cylinder>
</geometry><cloudcontact:cutter ability="1" efficiency="0.5" edge_speed="5"/></collision></link>
</model></world></sdf>)";

TEST_F(CommandTest, CuttingIsInTheJson) {
  std::ofstream(scene()) << kMilling;
  const auto json = nlohmann::json::parse(run(
      {"simulate", scene(), "--seconds", "0.1", "--step", "0.001", "--voxel", "0.001", "--json"}));
  ASSERT_EQ(json["cut"].size(), 1u);
  const auto& cut = json["cut"][0];
  EXPECT_EQ(cut["body"], "block");
  EXPECT_GT(cut["volume"].get<double>(), 1e-9);
  EXPECT_NEAR(cut["mass"].get<double>() / cut["volume"].get<double>(),
              dentalTissues().back().density, 1e-6 * dentalTissues().back().density);
  EXPECT_EQ(cut["pieces"], 0);
  EXPECT_EQ(json["unmeasured"], nlohmann::json::array({"block"}));
  EXPECT_NEAR(json["bodies"][1]["position"][0].get<double>(), -0.0085 + 0.006, 1e-7);
  EXPECT_NEAR(json["bodies"][1]["turns"][2].get<double>(), 30, 1e-3);
}

// By more than half a turn a step, which the orientations do not show.
TEST_F(CommandTest, ADrivenBodyTurnsAtItsVelocity) {
  std::ofstream(scene()) << kMilling;
  const auto json = nlohmann::json::parse(run(
      {"simulate", scene(), "--seconds", "0.1", "--step", "0.02", "--voxel", "0.001", "--json"}));
  EXPECT_NEAR(json["bodies"][1]["turns"][2].get<double>(), 30, 1e-3);
}

TEST_F(CommandTest, SleepsOnlyWithTheOption) {
  const std::vector<std::string> words = {"simulate", scene(),  "--seconds", "3",        "--voxel",
                                          "0.02",     "--json", "--method",  "primitive"};
  EXPECT_EQ(nlohmann::json::parse(run(words))["bodies"][1]["asleep"], false);
  auto sleepy = words;
  sleepy.push_back("--sleep");
  EXPECT_EQ(nlohmann::json::parse(run(sleepy))["bodies"][1]["asleep"], true);
}

TEST_F(CommandTest, TrajectoryHoldsEveryStepOfEveryMovingBody) {
  run({"simulate", scene(), "--seconds", "0.1", "--voxel", "0.02", "--trajectory", file("t.csv")});
  std::ifstream in(file("t.csv"));
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "time,body,x,y,z,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz");
  int rows = 0;
  while (std::getline(in, line)) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), 14) << line;
    EXPECT_EQ(line.substr(line.find(',') + 1, 6), "brick,") << line;
    ++rows;
  }
  EXPECT_EQ(rows, 21);  // the start and 20 steps
  EXPECT_FALSE(std::filesystem::exists(file("t.csv.partial")));
}

// Most of them are on the disk before the end.
TEST_F(CommandTest, ATrajectoryOfManyRowsIsWhole) {
  constexpr int kBalls = 100, kSteps = 2000;
  std::string text = "<sdf version=\"1.9\"><world name=\"w\"><gravity>0 0 0</gravity>";
  for (int i = 0; i < kBalls; ++i)
    text += "<model name=\"ball " + std::to_string(i) + "\"><pose>" + std::to_string(0.123456 * i) +
            " 0 0 0 0 0</pose><link name=\"l\"><collision name=\"c\"><geometry><sphere>"
            "<radius>0.01</radius></sphere></geometry></collision></link></model>";
  std::ofstream(file("many.sdf")) << text + "</world></sdf>";
  run({"simulate", file("many.sdf"), "--method", "primitive", "--voxel", "0.01", "--step", "0.001",
       "--seconds", "2", "--trajectory", file("t.csv")});
  std::ifstream in(file("t.csv"));
  std::string line;
  std::getline(in, line);
  int rows = 0;
  for (; std::getline(in, line); ++rows)
    EXPECT_NE(line.find(",ball " + std::to_string(rows % kBalls) + ","), std::string::npos) << line;
  EXPECT_EQ(rows, kBalls * (kSteps + 1));
}

TEST_F(CommandTest, RefusesByName) {
  const std::string where = scene();
  const std::vector<std::pair<std::vector<std::string>, const char*>> table = {
      {{"simulate", file("none.sdf")}, "none.sdf: no such file"},
      {{"simulate", where, "--seconds", "0"}, "--seconds"},
      {{"simulate", where, "--seconds", "nan"}, "--seconds"},
      {{"simulate", where, "--step", "-1"}, "--step"},
      {{"simulate", where, "--substeps", "0"}, "--substeps"},
      {{"simulate", where, "--substeps", "1.5"}, "--substeps"},
      {{"simulate", where, "--iterations", "none"}, "--iterations"},
      {{"simulate", where, "--replay", file("a.mp4")}, "--replay"},
      {{"simulate", where, "--trajectory", file("t.txt")}, "--trajectory"},
      {{"simulate", where, "--trajectory", file("no/such/t.csv")}, "--trajectory"},
      {{"simulate", where, "--method", "sdf", "--voxel", "0.02"}, "--method sdf"},
      {{"simulate", where, "--damping", "5", "--voxel", "0.02"}, "--damping"},
      {{"simulate", where, "--law", "foundation", "--method", "gjk", "--voxel", "0.02"}, "--law"},
      {{"simulate", where, "--law", "maxwell:3", "--voxel", "0.02"}, "maxwell:K,C"},
      {{"simulate", where, "--law", "solid:1,2,x", "--voxel", "0.02"}, "solid:K,K1,C1"},
      {{"simulate", where, "--law", "solid:1,2,3", "--stiffness", "1", "--voxel", "0.02"},
       "--stiffness"},
      {{"simulate", where, "--law", "solid:1,2,3", "--method", "gjk", "--voxel", "0.02"}, "--law"},
      {{"demo", "nut"}, "nut_bolt"},
      {{"demo", "chain", "--replay", file("a.mp4")}, "--replay"},
      {{"demo", "chain", "--pictures", file("folder")}, "--pictures: demo chain has none"},
      {{"demo", "--pictures", file("folder")}, "--pictures: needs a demo"},
      {{"demo", "drill", "--pictures", where}, "--pictures"}};
  for (const auto& [words, says] : table) {
    const std::string message = refusal(words);
    EXPECT_NE(message.find(says), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  // No incomplete file is left.
  for (const auto& entry : std::filesystem::directory_iterator(folder_))
    EXPECT_EQ(entry.path().filename(), "scene.sdf");
}

TEST_F(CommandTest, DemosAreListed) {
  const std::string list = run({"demo"});
  for (const char* name : {"nut_bolt", "peg_hole", "stack", "chain", "arm", "drill", "scalpel"})
    EXPECT_NE(list.find(name), std::string::npos) << name;
  EXPECT_EQ(demos().size(), 7u);
}

}  // namespace
}  // namespace cloudcontact::program::sim_command_test
