// `cloudcontact demo [NAME]`: lists the demos, or runs one and says whether it held.
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>

#include "commands.h"
#include "demo.h"

namespace cloudcontact::program {
namespace {

void list() {
  for (const Demo& demo : demos())
    std::cout << std::left << std::setw(10) << demo.name << demo.title << '\n';
  std::cout << "\nRun one with: cloudcontact demo NAME\n";
}

const Demo& find(const std::string& name) {
  std::string known;
  for (const Demo& demo : demos()) {
    if (demo.name == name) return demo;
    known += (known.empty() ? "" : ", ") + std::string(demo.name);
  }
  throw BadInput("demo: '" + name + "' is not known; use one of " + known);
}

void run(const std::string& name) {
  const Demo& demo = find(name);
  std::cout << demo.title << "\n" << demo.story << "\n" << std::endl;
  std::string expected, found;
  bool holds = true;
  for (const DemoCheck& check : demo.run()) {
    std::cout << (check.holds ? "  held    " : "  FAILED  ") << check.expected << ": "
              << check.found << '\n';
    expected += (expected.empty() ? "" : ", ") + check.expected;
    found += (found.empty() ? "" : ", ") + check.found;
    holds = holds && check.holds;
  }
  std::cout << demo.name << (holds ? " held" : " FAILED") << ": should be: " << expected
            << "; was: " << found << std::endl;
  if (!holds) throw WorkFailed(std::string("demo ") + demo.name + ": its own check did not hold");
}

}  // namespace

const std::vector<Demo>& demos() {
  static const std::vector<Demo> all = {
      {"nut_bolt", "An M16 nut on its bolt",
       "A nut on a thread slides down it under its own weight where friction is below the lead's\n"
       "slope, 2 mm a turn, and holds where it is above.",
       runNutBolt},
      {"peg_hole", "An 8 mm peg in a hole 0.1 mm wider",
       "The peg stands a little tilted in the hole's mouth and slides down to the floor.",
       runPegHole},
      {"stack", "Ten boxes on top of each other",
       "They stand for a minute at 240 Hz and at 60 Hz, with a stiffness stated and with none;\n"
       "beside them a stack of Bullet's own boxes.",
       runStack},
      {"chain", "Ten links of a chain", "They hang from the first, which is fixed, and hang still.",
       runChain}};
  return all;
}

SceneBody demoBody(const std::string& name, const std::string& kind,
                   std::shared_ptr<const Mesh> mesh, const Pose& pose, const DemoMatter& matter) {
  SceneBody body;
  body.name = name;
  body.pose = pose;
  body.isStatic = matter.mass == 0;
  if (matter.mass > 0) body.mass = matter.mass;
  body.friction = matter.friction;
  body.stiffness = matter.stiffness;
  body.damping = matter.damping;
  body.collisions.push_back({kind, Pose(), SceneMesh{kind, Vec3::Ones(), std::move(mesh)}});
  return body;
}

SceneBody demoFloor(double friction) {
  SceneBody body;
  body.name = "floor";
  body.isStatic = true;
  body.friction = friction;
  body.collisions.push_back({"floor", Pose(), ScenePlane{}});
  return body;
}

WorldSettings demoSettings(double voxel, Method method) {
  WorldSettings settings;
  settings.common.method = method;
  settings.voxel = voxel;
  return settings;
}

std::string figure(double value, int digits, const char* unit) {
  std::ostringstream out;
  out << std::fixed << std::setprecision(digits) << value << ' ' << unit;
  return out.str();
}

void addDemoCommand(CLI::App& app) {
  struct Options {
    std::string name;
  };
  auto options = std::make_shared<Options>();
  CLI::App& command = *app.add_subcommand(
      "demo", "list the demos, or run one; each checks its own outcome against physics");
  command.add_option("NAME", options->name, "the demo to run; without it they are listed");
  command
      .add_option_function<std::string>(
          "--replay",
          [](const std::string& text) {
            throw BadInput("--replay: '" + text + "' cannot be written, replays are not there yet");
          },
          "a replay to look at (not there yet)")
      ->type_name("OUT.glb|OUT.html");
  command.callback([options] { options->name.empty() ? list() : run(options->name); });
}

}  // namespace cloudcontact::program
