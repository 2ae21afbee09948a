// The program `cloudcontact`. It runs one of its commands; commands/command_line.h turns failures
// into exit codes.
#include <CLI/CLI.hpp>
#include "commands/command_line.h"
#include "commands/commands.h"
#include "commands/version_text.h"
#include "scene/scene_file.h"

namespace {

void addCommands(CLI::App& app) {
  using namespace cloudcontact::program;
  app.require_subcommand(1);
  app.set_version_flag(
      "--version", versionText,
      "print the version, Bullet's, vector instructions and OpenCL devices, and exit");
  addDigitizeCommand(app);
  addContactCommand(app);
  addSimulateCommand(app);
  addDemoCommand(app, robotOf);
  addChartCommand(app);
  addDrillCommand(app);
  addTuneCommand(app);
  addCompletionCommand(app);
  addManualCommand(app);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Contact between digital clouds: digitize bodies, find their contacts, simulate.",
               "cloudcontact");
  return cloudcontact::program::runCommandLine(argc, argv, app, addCommands);
}
