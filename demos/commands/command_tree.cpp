// The program's commands and options as plain values (command_tree.h).
#include "commands/command_tree.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <sstream>

namespace cloudcontact::program {
namespace {

constexpr const char* kExamples = "Examples:\n";

std::string oneLine(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

OptionText optionText(const CLI::Option& option) {
  OptionText text;
  for (const std::string& name : option.get_lnames()) text.names.push_back("--" + name);
  for (const std::string& name : option.get_snames()) text.names.push_back("-" + name);
  if (option.get_items_expected_max() > 0)
    text.word = text.names.empty() ? option.get_name() : option.get_type_name();
  text.help = oneLine(option.get_description());
  return text;
}

}  // namespace

std::vector<std::string> OptionText::choices() const {
  std::vector<std::string> values;
  if (word.find('|') == std::string::npos) return values;
  std::istringstream parts(word);
  for (std::string value; std::getline(parts, value, '|');) {
    // A word in capitals stands for a value.
    if (std::any_of(value.begin(), value.end(), [](char c) { return c < 'a' || c > 'z'; }))
      continue;
    values.push_back(value);
  }
  return values;
}

CommandText commandText(const CLI::App& app) {
  CommandText text;
  text.name = app.get_name();
  text.help = app.get_description();
  for (const CLI::Option* option : app.get_options()) {
    OptionText known = optionText(*option);
    (known.names.empty() ? text.positionals : text.options).push_back(std::move(known));
  }
  std::istringstream footer(app.get_footer());
  for (std::string line; std::getline(footer, line);)
    if (line.starts_with("  ")) text.examples.push_back(line.substr(2));
  return text;
}

std::vector<CommandText> commandTexts(const CLI::App& app) {
  std::vector<CommandText> texts;
  for (const CLI::App* command : app.get_subcommands(nullptr))
    texts.push_back(commandText(*command));
  return texts;
}

std::vector<std::string> chartExamples() {
  return {"cloudcontact chart --quick --out bench-results",
          R"(cloudcontact chart bolt.stl nut.stl --unit mm --pose "0 0 0.0078")"};
}

void addExamples(CLI::App& command, const std::vector<std::string>& lines) {
  std::string footer = kExamples;
  for (const std::string& line : lines) footer += "  " + line + "\n";
  command.footer(footer);
}

}  // namespace cloudcontact::program
