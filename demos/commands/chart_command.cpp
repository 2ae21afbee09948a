// `cloudcontact chart`: starts the laboratory, the program cloudcontact-chart in the same folder. A
// separate program, so that demos and commands are built without it and the libraries it compares
// with.
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "commands/command_tree.h"
#include "commands/commands.h"

namespace cloudcontact::program {
namespace {

std::filesystem::path laboratory() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "cloudcontact-chart";
}

// Does not return: this process becomes the laboratory.
[[noreturn]] void start(std::vector<std::string> arguments) {
  const std::string program = laboratory();
  std::vector<char*> words = {const_cast<char*>(program.c_str())};
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  execv(program.c_str(), words.data());
  throw WorkFailed("chart: " + program +
                   " cannot be started; build it: cmake --build --preset release --target "
                   "cloudcontact-chart");
}

}  // namespace

void addChartCommand(CLI::App& app) {
  CLI::App& command = *app.add_subcommand(
      "chart",
      "measure speed against accuracy, and stability where methods fail, for all methods; or\n"
      "chart a pair of your own, with its finest voxels as the reference.");
  command.set_help_flag();  // the laboratory prints its own help
  command.prefix_command();
  addExamples(command, chartExamples());
  command.callback([&command] { start(command.remaining()); });
}

}  // namespace cloudcontact::program
