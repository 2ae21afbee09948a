// Parses a command line and turns what goes wrong into one line on stderr and an exit code.
#include "commands/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <iostream>
#include <new>
#include <string>

#include "io/errors.h"

namespace cloudcontact::program {

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

// CLI11's own message and which help to read; without a command, the list of commands.
std::string messageOf(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv) {
  const auto chosen = app.get_subcommands();
  if (!chosen.empty())
    return std::string(error.what()) + "; see cloudcontact " + chosen.front()->get_name() +
           " --help";
  if (app.get_subcommands(nullptr).empty()) return std::string(error.what()) + "; see --help";
  std::string commands;
  for (const CLI::App* command : app.get_subcommands(nullptr))
    commands += (commands.empty() ? "" : ", ") + command->get_name();
  const std::string given =
      argc > 1 ? "'" + std::string(argv[1]) + "' is no command" : "no command";
  return given + "; give one of " + commands + ", or --help";
}

int parse(int argc, char** argv, CLI::App& app) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    return complain(messageOf(app, error, argc, argv), kBadInput);
  }
  return 0;
}

}  // namespace

int runCommandLine(int argc, char** argv, CLI::App& app, void (*add)(CLI::App&)) noexcept {
  try {
    add(app);
    return parse(argc, argv, app);
  } catch (const BadInput& error) {
    return complain(error.what(), kBadInput);
  } catch (const std::bad_alloc&) {
    return complain("this needs more memory than there is; give a larger --voxel", kBadInput);
  } catch (const std::exception& error) {
    return complain(error.what(), kWorkFailed);
  }
}

}  // namespace cloudcontact::program
