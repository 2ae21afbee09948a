// Parses a command line and turns what goes wrong into one line on stderr and an exit code.
#include "commands/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <string_view>

#include "io/errors.h"

namespace cloudcontact::program {

namespace {

constexpr int kWorkFailed = 1;
constexpr int kBadInput = 2;

void replaceAll(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at))
    text.replace(at, from.size(), to), at += to.size();
}

// One line, whatever a library put into its message, with this program's names of settings.
int complain(std::string message, int code) {
  replaceAll(message, " voxelSize", " --voxel");
  replaceAll(message, "maxBytes allows", "the limit is");
  replaceAll(message, ", or raise maxBytes", "");
  replaceAll(message, "shell()", "--shell");
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

// Refuses an empty value: a script's unset variable would drop an output without a word.
void refuseEmpty(int argc, char** argv) {
  for (int k = 1; k < argc; ++k) {
    const std::string_view given = argv[k];
    const bool joined = given.starts_with("--") && given.ends_with('=');
    if (!given.empty() && !joined) continue;
    const std::string_view option = joined ? given.substr(0, given.size() - 1) : argv[k - 1];
    throw BadInput((option.starts_with('-') ? std::string(option) : std::string("arguments")) +
                   ": an empty value; give one, or leave it out");
  }
}

int parse(int argc, char** argv, CLI::App& app) {
  refuseEmpty(argc, argv);
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
    const int code = parse(argc, argv, app);
    if (!std::cout.flush())
      return complain("the results could not be written whole; check where they are sent",
                      kWorkFailed);
    return code;
  } catch (const BadInput& error) {
    return complain(error.what(), kBadInput);
  } catch (const std::bad_alloc&) {
    return complain("this needs more memory than there is; give a larger --voxel", kBadInput);
  } catch (const std::exception& error) {
    return complain(error.what(), kWorkFailed);
  }
}

}  // namespace cloudcontact::program
