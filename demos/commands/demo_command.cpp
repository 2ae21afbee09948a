// `cloudcontact demo [NAME]`: lists the demos, or runs one and reports its checks.
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>

#include "commands/command_tree.h"
#include "commands/commands.h"
#include "demos/demo.h"
#include "draw/picture_file.h"
#include "replay/replay_file.h"

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

void print(const Demo& demo, const std::vector<ReplayCheck>& checks) {
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

// Creates the folder if needed.
void checkPictures(const Demo& demo, const std::string& folder) {
  namespace fs = std::filesystem;
  if (!demo.draws)
    throw BadInput(std::string("--pictures: demo ") + demo.name +
                   " has none; leave it out, or use --replay");
  std::error_code error;
  fs::create_directories(folder, error);
  if (!fs::is_directory(folder, error) || access(folder.c_str(), W_OK) != 0)
    throw BadInput("--pictures: " + folder + " is not a writable folder; choose another");
}

// Writes the replay even if a check fails, because then it matters most.
void run(const std::string& name, const std::string& replay, const std::string& pictures,
         const RobotReader& readRobot) {
  const Demo& demo = find(name);
  if (demo.asksRobot && !readRobot)
    throw BadInput("demo " + name + ": reads a URDF file, which this program cannot; use " +
                   "`cloudcontact demo " + name + "`");
  if (!replay.empty()) checkReplay(replay);
  if (!pictures.empty()) checkPictures(demo, pictures);
  std::cout << demo.title << "\n" << demo.story << "\n" << demo.watch << "\n" << std::endl;
  DemoStage stage(!replay.empty(), !pictures.empty());
  stage.readRobot = readRobot;
  const std::vector<ReplayCheck> checks = demo.run(stage);
  print(demo, checks);
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
    throw WorkFailed(std::string("demo ") + demo.name + ": its own check failed");
}

}  // namespace

void addDemoCommand(CLI::App& app, RobotReader readRobot) {
  struct Options {
    std::string name, replay, pictures;
  };
  auto options = std::make_shared<Options>();
  CLI::App& command = *app.add_subcommand(
      "demo", "list the demos, or run one; each checks its own outcome against physics");
  command.add_option("NAME", options->name, "the demo to run; without it they are listed");
  command
      .add_option("--replay", options->replay,
                  "file for a replay: animated glTF, or a page for any browser")
      ->type_name("OUT.glb|OUT.html");
  command
      .add_option("--pictures", options->pictures,
                  "folder for the pictures of arm, drill and scalpel, as SVG and PNG")
      ->type_name("DIR");
  addExamples(command, {"cloudcontact demo", "cloudcontact demo nut_bolt --replay nut_bolt.html"});
  command.callback([options, readRobot = std::move(readRobot)] {
    if (options->name.empty() && !options->replay.empty())
      throw BadInput("--replay: needs a demo; give its name");
    if (options->name.empty() && !options->pictures.empty())
      throw BadInput("--pictures: needs a demo; give its name");
    options->name.empty() ? list()
                          : run(options->name, options->replay, options->pictures, readRobot);
  });
}

}  // namespace cloudcontact::program
