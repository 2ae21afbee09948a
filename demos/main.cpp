// The program `cloudcontact`: reads the command line, runs one command, turns what went wrong into
// one line on stderr and an exit code (0 done, 1 the work failed, 2 bad input).
#include <algorithm>
#include <exception>
#include <iostream>
#include <new>
#include <string>

#include "commands.h"

namespace {

constexpr int kWorkFailed = 1;
constexpr int kBadInput = 2;

// One line, whatever a library put into its message.
int complain(std::string message, int code) {
  while (!message.empty() && message.back() == '\n') message.pop_back();
  std::replace(message.begin(), message.end(), '\n', ' ');
  std::cerr << "cloudcontact: " << message << '\n';
  return code;
}

// CLI11's own words, the command's help named; where no command was, which ones there are.
std::string whatIsWrong(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv) {
  const auto chosen = app.get_subcommands();
  if (!chosen.empty())
    return std::string(error.what()) + "; see cloudcontact " + chosen.front()->get_name() +
           " --help";
  std::string commands;
  for (const CLI::App* command : app.get_subcommands(nullptr))
    commands += (commands.empty() ? "" : ", ") + command->get_name();
  const std::string given =
      argc > 1 ? "'" + std::string(argv[1]) + "' is no command" : "no command";
  return given + "; give one of " + commands + ", or --help";
}

int run(int argc, char** argv) {
  using namespace cloudcontact::program;
  CLI::App app("Contact between digital clouds: digitise bodies, press them together, simulate.",
               "cloudcontact");
  app.require_subcommand(1);
  app.set_version_flag("--version", CLOUDCONTACT_VERSION);
  addDigitizeCommand(app);
  addContactCommand(app);
  addSimulateCommand(app);
  addDemoCommand(app);
  addChartCommand(app);
  addDrillCommand(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    return complain(whatIsWrong(app, error, argc, argv), kBadInput);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const cloudcontact::program::BadInput& error) {
    return complain(error.what(), kBadInput);
  } catch (const std::bad_alloc&) {
    return complain("out of memory; give a larger --voxel", kWorkFailed);
  } catch (const std::exception& error) {
    return complain(error.what(), kWorkFailed);
  }
}
