// The program's commands and options as plain values, from the same place as --help.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace cloudcontact::program {

struct OptionText {
  std::vector<std::string> names;  // "--voxel", "-h"; empty for a positional
  std::string word;                // what it takes: "H", "cpu|opencl"; empty for a flag
  std::string help;                // one line
  bool isFlag() const { return word.empty(); }
  // The values, where its word lists them.
  std::vector<std::string> choices() const;
};

struct CommandText {
  std::string name;
  std::string help;  // several lines
  std::vector<OptionText> options, positionals;
  std::vector<std::string> examples;  // lines of a shell

  std::string firstLine() const { return help.substr(0, help.find('\n')); }
};

// Of all commands, in their order.
std::vector<CommandText> commandTexts(const CLI::App& app);
// Of one, or of the program itself.
CommandText commandText(const CLI::App& app);

// Lines of a shell that `--help` ends with.
void addExamples(CLI::App& command, const std::vector<std::string>& lines);
// Of `chart`, and of the program that it starts, whose help is the command's.
std::vector<std::string> chartExamples();

}  // namespace cloudcontact::program
