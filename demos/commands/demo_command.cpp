// `cloudcontact demo [NAME]`: lists the demos, or runs one and says whether it held.
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>

#include "commands/commands.h"
#include "demos/demo.h"
#include "draw/picture_file.h"
#include "io/progress.h"
#include "replay/replay_file.h"
#include "replay/words.h"

namespace cloudcontact::program {
namespace {

void list() {
  for (const Demo& demo : demos())
    std::cout << std::left << std::setw(10) << demo.name << demo.title << '\n';
  std::cout << "\nRun one with: cloudcontact demo NAME\n";
}

bool allHold(const std::vector<ReplayCheck>& checks) {
  return std::all_of(checks.begin(), checks.end(), [](const auto& c) { return c.holds; });
}

const Demo& find(const std::string& name) {
  std::string known;
  for (const Demo& demo : demos()) {
    if (demo.name == name) return demo;
    known += (known.empty() ? "" : ", ") + std::string(demo.name);
  }
  throw BadInput("demo: '" + name + "' is not known; use one of " + known);
}

void tell(const Demo& demo, const std::vector<ReplayCheck>& checks) {
  std::string expected, found;
  for (const ReplayCheck& check : checks) {
    std::cout << (check.holds ? "  held    " : "  FAILED  ") << check.expected << ": "
              << check.found << '\n';
    expected += (expected.empty() ? "" : ", ") + check.expected;
    found += (found.empty() ? "" : ", ") + check.found;
  }
  std::cout << demo.name << (allHold(checks) ? " held" : " FAILED") << ": should be: " << expected
            << "; was: " << found << std::endl;
}

// Made where it is not there.
void checkPictures(const Demo& demo, const std::string& folder) {
  namespace fs = std::filesystem;
  if (!demo.draws)
    throw BadInput(std::string("--pictures: demo ") + demo.name +
                   " draws none; leave it out, or use --replay");
  std::error_code error;
  fs::create_directories(folder, error);
  if (!fs::is_directory(folder, error) || access(folder.c_str(), W_OK) != 0)
    throw BadInput("--pictures: " + folder + " is no folder that can be written; choose another");
}

// A demo that fails is one to look at all the more: its replay is written first.
void run(const std::string& name, const std::string& replay, const std::string& pictures) {
  const Demo& demo = find(name);
  if (!replay.empty()) checkReplay(replay);
  if (!pictures.empty()) checkPictures(demo, pictures);
  std::cout << demo.title << "\n" << demo.story << "\n" << demo.watch << "\n" << std::endl;
  DemoStage stage(!replay.empty(), !pictures.empty());
  const std::vector<ReplayCheck> checks = demo.run(stage);
  tell(demo, checks);
  if (!replay.empty()) {
    Replay shown = stage.replay();
    shown.title = demo.title;
    shown.story = demo.story;
    shown.watch = demo.watch;
    shown.checks = checks;
    saveReplay(shown, replay);
    std::cout << "replay: " << replay << std::endl;
  }
  for (const auto& [file, drawing] : stage.pictures())
    for (const char* ending : {".svg", ".png"}) {
      const std::string path = (std::filesystem::path(pictures) / (file + ending)).string();
      savePicture(*drawing, path);
      std::cout << "picture: " << path << std::endl;
    }
  if (!allHold(checks))
    throw WorkFailed(std::string("demo ") + demo.name + ": its own check did not hold");
}

}  // namespace

const std::vector<Demo>& demos() {
  static const std::vector<Demo> all = {
      {"nut_bolt", "An M16 nut on its bolt",
       "The same nut and bolt twice: at friction 0.01, below the slope of the thread, and at 0.3, "
       "above it.",
       "On the left the nut turns down under its own weight, 2 mm a turn; on the right it stays "
       "where it is. Cut the bodies open to see the flanks press.",
       runNutBolt},
      {"peg_hole", "An 8 mm peg in a hole 0.1 mm wider",
       "The peg stands a little tilted in the hole's mouth, and off its axis.",
       "It rights itself on the hole's wall, slides down without jamming and lies still on the "
       "floor. Cut the bodies open to see it inside.",
       runPegHole},
      {"stack", "Ten boxes on top of each other",
       "Ten boxes of a tonne each, five times: clouds at 240 and 60 steps a second, with a "
       "stiffness stated and with none, and Bullet's own boxes at 60.",
       "All stacks of clouds stand for a minute, without sleeping; the stack of Bullet's own boxes "
       "leans over and falls.",
       runStack},
      {"chain", "Ten links of a chain",
       "Ten links hang from the first, which is fixed. Each carries all that is below it.",
       "They hang still; forces grow from link to link upward, and with them the depth.", runChain},
      {"drill", "A bur opens a tooth",
       "A ball bur in a simulated hand drills through enamel into the caries below, down to just "
       "above the pulp, and clears a cavity along the fissure.",
       "The force falls as the bur leaves enamel. With --pictures DIR: the force over time by "
       "tissue, and the opened tooth.",
       runDrill, true},
      {"scalpel", "A blade slits skin",
       "A thin blade whose rim alone cuts is drawn through skin and the muscle below it.",
       "The slit stays open behind the blade. With --pictures DIR: the force over time, and the "
       "slab that is left.",
       runScalpel, true}};
  return all;
}

SimulationReport DemoStage::run(const SceneDescription& scene, const WorldSettings& settings,
                                const SimulationSettings& simulation, const std::string& label) {
  World world(scene, settings);
  setups_.insert(setupText(settings, simulation.step, simulation.substeps));
  if (settings.common.method == Method::Cloud) voxel_ = std::max(voxel_, settings.voxel);
  if (watched_) recorder_.begin(world, label, simulation.seconds, simulation.step);
  const auto progress =
      progressBar("simulating " + scene.name + (label.empty() ? "" : " (" + label + ")"));
  SimulationSettings watched = simulation;
  watched.observe = [&](double time, const World& now) {
    if (watched_) recorder_.record(time, now);
    if (progress) progress(std::min(1.0, time / simulation.seconds));
  };
  const SimulationReport report = simulate(world, watched);
  if (progress) progress(1);  // whatever rounding made of the last time
  return report;
}

void DemoStage::addTakes(std::vector<ReplayTake> takes, double seconds, const std::string& setup,
                         double voxel) {
  for (ReplayTake& take : takes) takes_.push_back(std::move(take));
  seconds_ = std::max(seconds_, seconds);
  setups_.insert(setup);
  voxel_ = std::max(voxel_, voxel);
}

void DemoStage::addPicture(const std::string& name, std::shared_ptr<const Drawing> drawing) {
  pictures_.emplace_back(name, std::move(drawing));
}

Replay DemoStage::replay() {
  Replay replay = recorder_.finish();
  for (ReplayTake& take : takes_) replay.takes.push_back(std::move(take));
  replay.seconds = std::max(replay.seconds, seconds_);
  if (setups_.size() == 1) replay.setup = *setups_.begin();  // else the labels tell
  replay.voxel = voxel_;
  return replay;
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
  out << std::fixed << std::setprecision(digits) << value;
  if (*unit) out << ' ' << unit;
  return out.str();
}

void addDemoCommand(CLI::App& app) {
  struct Options {
    std::string name, replay, pictures;
  };
  auto options = std::make_shared<Options>();
  CLI::App& command = *app.add_subcommand(
      "demo", "list the demos, or run one; each checks its own outcome against physics");
  command.add_option("NAME", options->name, "the demo to run; without it they are listed");
  command
      .add_option("--replay", options->replay,
                  "a replay: an animated glTF file, or a page that any browser shows")
      ->type_name("OUT.glb|OUT.html");
  command
      .add_option("--pictures", options->pictures,
                  "a folder for a demo's pictures, as SVG and PNG: drill, scalpel")
      ->type_name("DIR");
  command.callback([options] {
    if (options->name.empty() && !options->replay.empty())
      throw BadInput("--replay: of which demo? give its name");
    if (options->name.empty() && !options->pictures.empty())
      throw BadInput("--pictures: of which demo? give its name");
    options->name.empty() ? list() : run(options->name, options->replay, options->pictures);
  });
}

}  // namespace cloudcontact::program
