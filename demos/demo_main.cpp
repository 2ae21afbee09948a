// The program cloudcontact-demo: the command `demo` alone, which compiles in a fraction of the time
// of all commands.
#include <CLI/CLI.hpp>

#include "commands/command_line.h"
#include "commands/commands.h"

int main(int argc, char** argv) {
  CLI::App app("CloudContact's demos; each checks its own outcome.", "cloudcontact");
  return cloudcontact::program::runCommandLine(argc, argv, app, [](CLI::App& all) {
    all.require_subcommand(1);
    cloudcontact::program::addDemoCommand(all);
  });
}
