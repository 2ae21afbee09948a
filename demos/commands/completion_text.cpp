// Completion scripts for bash, zsh and fish (completion_text.h). Where no words are known, shells
// complete files.
#include "commands/completion_text.h"

namespace cloudcontact::program {
namespace {

std::string joined(const std::vector<std::string>& words, const char* between = " ") {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

std::vector<std::string> namesOf(const std::vector<OptionText>& options) {
  std::vector<std::string> names;
  for (const OptionText& option : options)
    names.insert(names.end(), option.names.begin(), option.names.end());
  return names;
}

std::vector<std::string> namesOf(const std::vector<CommandText>& commands) {
  std::vector<std::string> names;
  for (const CommandText& command : commands) names.push_back(command.name);
  return names;
}

// In single quotes of a shell; `special` are characters that also take a backslash.
std::string quoted(const std::string& text, const std::string& special = "") {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'')
      out += "'\\''";
    else
      out += (special.find(c) != std::string::npos ? "\\" : "") + std::string(1, c);
  }
  return out + "'";
}

// "$command $previous" and the words that follow them.
std::string bashChoices(const CommandText& command) {
  std::string cases;
  for (const OptionText& option : command.options)
    for (const std::string& name : option.names)
      if (!option.choices().empty())
        cases += "    \"" + command.name + " " + name + "\") words=\"" + joined(option.choices()) +
                 "\" ;;\n";
  for (const OptionText& positional : command.positionals)
    if (!positional.choices().empty())
      cases += "    \"" + command.name + " " + command.name + "\") words=\"" +
               joined(positional.choices()) + "\" ;;\n";
  return cases;
}

std::string zshArguments(const CommandText& command) {
  std::string arguments;
  for (const OptionText& option : command.options)
    for (const std::string& name : option.names) {
      std::string values;
      if (!option.isFlag())
        values =
            ": :" + (option.choices().empty() ? "_files" : "(" + joined(option.choices()) + ")");
      // In its help brackets and colons are _arguments' own.
      const std::string help = quoted(option.help, "[]:\\");
      arguments += " \\\n        " + name + "'['" + help + "']" + values + "'";
    }
  for (const OptionText& positional : command.positionals)
    if (!positional.choices().empty())
      return arguments + " \\\n        '1: :(" + joined(positional.choices()) + ")'";
  return arguments + " \\\n        '*:file:_files'";
}

}  // namespace

std::string bashCompletion(const CommandText& program, const std::vector<CommandText>& commands) {
  std::string choices, options;
  for (const CommandText& command : commands) {
    choices += bashChoices(command);
    options +=
        "      " + command.name + ") words=\"" + joined(namesOf(command.options)) + "\" ;;\n";
  }
  return "# bash completion of " + program.name + "\n_" + program.name +
         "() {\n"
         "  local word=${COMP_WORDS[COMP_CWORD]} command=${COMP_WORDS[1]} words=\n"
         "  COMPREPLY=()\n"
         "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
         "    COMPREPLY=($(compgen -W \"" +
         joined(namesOf(commands)) + " " + joined(namesOf(program.options)) +
         "\" -- \"$word\"))\n"
         "    return\n"
         "  fi\n"
         "  case \"$command ${COMP_WORDS[COMP_CWORD-1]}\" in\n" +
         choices +
         "  esac\n"
         "  if [ -z \"$words\" ] && [ \"${word#-}\" != \"$word\" ]; then\n"
         "    case $command in\n" +
         options +
         "    esac\n"
         "  fi\n"
         "  if [ -n \"$words\" ]; then\n"
         "    COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
         "  else\n"
         "    COMPREPLY=($(compgen -f -- \"$word\"))\n"
         "  fi\n"
         "}\n"
         "complete -o filenames -F _" +
         program.name + " " + program.name + "\n";
}

std::string zshCompletion(const CommandText& program, const std::vector<CommandText>& commands) {
  std::string list, cases;
  for (const CommandText& command : commands) {
    list += "      " + quoted(command.name + ":" + command.firstLine()) + "\n";
    cases += "    " + command.name + ")\n      _arguments -S" + zshArguments(command) + " ;;\n";
  }
  return "#compdef " + program.name + "\n_" + program.name +
         "() {\n"
         "  if (( CURRENT == 2 )); then\n"
         "    local -a commands=(\n" +
         list +
         "    )\n"
         "    _describe command commands\n"
         "    return\n"
         "  fi\n"
         "  local command=$words[2]\n"
         "  shift words\n"
         "  (( CURRENT-- ))\n"
         "  case $command in\n" +
         cases + "  esac\n}\n_" + program.name + " \"$@\"\n";
}

std::string fishCompletion(const CommandText& program, const std::vector<CommandText>& commands) {
  const std::string start = "complete -c " + program.name;
  std::string text = "# fish completion of " + program.name + "\n";
  for (const CommandText& command : commands)
    text += start + " -f -n __fish_use_subcommand -a " + command.name + " -d " +
            quoted(command.firstLine(), "\\") + "\n";
  for (const CommandText& command : commands) {
    const std::string within =
        start + " -n " + quoted("__fish_seen_subcommand_from " + command.name);
    for (const OptionText& option : command.options) {
      std::string line = within;
      for (const std::string& name : option.names)
        line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (!option.isFlag()) line += " -r";
      if (!option.choices().empty()) line += " -f -a " + quoted(joined(option.choices()));
      text += line + " -d " + quoted(option.help, "\\") + "\n";
    }
    for (const OptionText& positional : command.positionals)
      if (!positional.choices().empty())
        text += within + " -f -a " + quoted(joined(positional.choices())) + "\n";
  }
  return text;
}

}  // namespace cloudcontact::program
