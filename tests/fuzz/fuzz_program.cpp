// What the program reads: scenes, tables of tissues, and values of options.
#include <CLI/CLI.hpp>

#include "commands/command_line.h"
#include "fuzz/fuzz_input.h"
#include "fuzz/fuzz_target.h"
#include "io/errors.h"
#include "io/options.h"
#include "io/solid_text.h"
#include "scene/scene_file.h"
#include "scene/tissue_file.h"

namespace cloudcontact::fuzz {

namespace {

namespace fs = std::filesystem;
using namespace program;

void readScene(std::string_view input) {
  const bool robot = input.find("<robot") != std::string_view::npos;
  const fs::path file = inputFile(robot ? "scene.urdf" : "scene.sdf", input);
  mayRefuse("scene.", [&] {
    const SceneDescription scene = loadScene(file);
    require(!scene.bodies.empty() && scene.gravity.allFinite() && scene.step > 0,
            "a scene that makes no sense");
    for (const SceneBody& body : scene.bodies)
      require(body.pose.position.allFinite() && (!body.mass || *body.mass > 0),
              "a body's pose or mass");
  });
}

std::string world(const std::string& inner) {
  return "<sdf version=\"1.9\" xmlns:cloudcontact=\"http://cloudcontact\"><world name=\"w\">" +
         inner + "</world></sdf>";
}

std::vector<std::string> sceneSeeds() {
  const std::string box = "<geometry><box><size>1 2 3</size></box></geometry>";
  const std::string link =
      "<link name=\"l\"><pose>0 0 1 0 0 "
      "0.1</pose><inertial><mass>2</mass><inertia><ixx>1</ixx><iyy>1</iyy>"
      "<izz>1</izz></inertia></inertial><collision name=\"c\">" +
      box +
      "<surface><friction><ode><mu>0.4</mu></ode></friction><contact><ode><kp>1e5</kp><kd>10</kd></"
      "ode>"
      "</contact></surface></collision></link>";
  return {world("<gravity>0 0 -9.8</gravity><physics name=\"p\" "
                "type=\"x\"><max_step_size>0.001</max_step_size>"
                "<real_time_factor>1</real_time_factor></physics><model name=\"m\">" +
                link + "</model>"),
          world("<model name=\"g\"><static>true</static><link name=\"l\"><collision "
                "name=\"c\"><geometry><plane>"
                "<normal>0 0 1</normal></plane></geometry></collision></link></model>"),
          world("<model name=\"m\">" + link +
                "<link name=\"k\"><collision name=\"c\"><geometry><sphere><radius>1"
                "</radius></sphere></geometry></collision></link><joint name=\"j\" "
                "type=\"revolute\"><parent>l</parent>"
                "<child>k</child><axis><xyz>0 0 "
                "1</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis>"
                "</joint></model><state world_name=\"w\"><model name=\"m\"><pose>0 0 2 0 0 "
                "0</pose></model></state>"),
          world("<model name=\"m\"><link name=\"l\"><collision name=\"c\"><cloudcontact:cuttable/>"
                "<cloudcontact:tissue>dentin</cloudcontact:tissue>" +
                box + "</collision></link></model>"),
          "<robot name=\"r\"><link name=\"l\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" "
          "ixy=\"0\" ixz=\"0\" "
          "iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial><collision><geometry><box size=\"1 1 "
          "1\"/></geometry>"
          "</collision></link></robot>"};
}

void readTable(std::string_view input) {
  const fs::path file = inputFile("table.json", input);
  mayRefuse("table.json", [&] { validate(readTissues("--tissues", file.string())); });
}

std::vector<std::string> tableSeeds() {
  return {
      "[{\"name\": \"bone\", \"stiffness\": 1e5, \"damping\": 2, \"hardness\": 1e9, \"density\": "
      "1900}]",
      "[{\"name\": \"a\", \"stiffness\": 1, \"damping\": 0, \"hardness\": 0, \"density\": 1, "
      "\"elasticity\": 9},"
      "{\"name\": \"b\", \"stiffness\": 3, \"damping\": 0, \"hardness\": 0, \"density\": 1}]"};
}

// A stand-in for the commands: their readers, without what they would do.
void addReaders(CLI::App& app) {
  static std::string text;
  text.clear();
  const auto option = [&](const char* name, void (*read)(const std::string&)) {
    app.add_option_function<std::string>(name, [read](const std::string& value) { read(value); });
  };
  option("--law", [](const std::string& v) {
    const Law law = readLaw(v);  // `paper` and `foundation` get their k and c later
    if (!std::holds_alternative<KelvinVoigt>(law) && !std::holds_alternative<Foundation>(law))
      validate(law);
  });
  option("--method", [](const std::string& v) { readMethod(v); });
  option("--unit", [](const std::string& v) { require(readUnit(v) > 0, "a unit"); });
  option("--voxel",
         [](const std::string& v) { require(readPositive("--voxel", v) > 0, "a voxel"); });
  option("--count",
         [](const std::string& v) { require(readCount("--count", v, 1, 9) > 0, "a count"); });
  option("--pose", [](const std::string& v) {
    const Pose pose = readPose("--pose", v);
    require(pose.position.allFinite() && std::abs(pose.orientation.norm() - 1) < 1e-6, "a pose");
  });
  option("--velocity", [](const std::string& v) { readVelocity("--velocity", v); });
  option("--tissue", [](const std::string& v) { readTissueName("--tissue", v); });
  option("--threshold", [](const std::string& v) {
    std::vector<CtRange> ranges{{1, "first"}};
    addThreshold("--threshold", readThreshold("--threshold", v), ranges);
  });
  option("--window", [](const std::string& v) { readWindow("--window", v); });
  app.add_option_function<std::string>("body", [](const std::string& v) {
    if (const auto solid = readPrimitive(v); solid && !std::holds_alternative<HalfSpace>(*solid))
      validate(PlacedSolid{*solid, {}});
  });
}

// Words are separated by line ends.
void readOptions(std::string_view input) {
  std::vector<std::string> words = {"cloudcontact"};
  for (std::size_t at = 0; at <= input.size();) {
    const std::size_t end = std::min(input.find('\n', at), input.size());
    words.emplace_back(input.substr(at, end - at));
    at = end + 1;
  }
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  CLI::App app("options", "cloudcontact");
  std::ostringstream said;
  std::streambuf* const out = std::cout.rdbuf(said.rdbuf());
  std::streambuf* const err = std::cerr.rdbuf(said.rdbuf());
  const int code = runCommandLine(static_cast<int>(argv.size()), argv.data(), app, addReaders);
  std::cout.rdbuf(out), std::cerr.rdbuf(err);
  require(code == 0 || code == 2,
          "bad input ends with " + std::to_string(code) + ": " + said.str());
}

std::vector<std::string> optionSeeds() {
  return {"--pose\n1 2 3 0 0 0 1\n--voxel\n0.001\nsphere:0.1",
          "--law\nsolid:1e4,1e3,10\n--unit\nmm\nbox:1,2,3",
          "--threshold\nbone=700\n--tissue\na=b\n--window\nellipsoid:1,2,3",
          "--velocity\n1 2 3 4 5 6\n--count\n3\n--method\npaper\n--unit\n0.0254\ncone:1,2",
          "--help",
          "--law\nmaxwell:1e4,1"};
}

}  // namespace

Target sceneTarget() {
  return {"scene", readScene, sceneSeeds, 4096};
}
Target tissuesTarget() {
  return {"tissues", readTable, tableSeeds, 4096};
}
Target optionsTarget() {
  return {"options", readOptions, optionSeeds, 512};
}

}  // namespace cloudcontact::fuzz
