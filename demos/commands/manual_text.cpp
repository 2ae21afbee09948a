// The manual page in roff (manual_text.h).
#include "commands/manual_text.h"

#include <cloudcontact/version.h>

#include <sstream>

namespace cloudcontact::program {
namespace {

// Plain text of roff: backslashes, hyphens and a line's first dot or quote are its own.
std::string plain(const std::string& text) {
  std::string out;
  bool starts = true;
  for (const char c : text) {
    if (starts && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
    starts = c == '\n';
  }
  return out;
}

std::string optionLine(const OptionText& option) {
  std::string names;
  for (const std::string& name : option.names)
    names += (names.empty() ? "" : ", ") + ("\\fB" + plain(name)) + "\\fR";
  if (!option.word.empty())
    names += (names.empty() ? "" : " ") + ("\\fI" + plain(option.word)) + "\\fR";
  return ".TP\n" + names + "\n" + plain(option.help) + "\n";
}

std::string commandSection(const std::string& program, const CommandText& command) {
  std::string text =
      ".SS " + plain(command.name) + "\n\\fB" + program + " " + plain(command.name) + "\\fR";
  for (const OptionText& positional : command.positionals)
    text += " \\fI" + plain(positional.word) + "\\fR";
  text += " [\\fIoptions\\fR]\n.PP\n" + plain(command.help) + "\n";
  for (const OptionText& positional : command.positionals) text += optionLine(positional);
  for (const OptionText& option : command.options) text += optionLine(option);
  if (command.examples.empty()) return text;
  text += ".PP\nExamples:\n.PP\n.nf\n";
  for (const std::string& example : command.examples) text += plain(example) + "\n";
  return text + ".fi\n";
}

}  // namespace

std::string manualPage(const CommandText& program, const std::vector<CommandText>& commands) {
  const std::string& name = program.name;
  std::string text =
      ".TH CLOUDCONTACT 1 \"\" \"" + name + " " + std::string(version()) + "\"\n" + ".SH NAME\n" +
      name + " \\- contact between digital clouds\n" + ".SH SYNOPSIS\n\\fB" + name +
      "\\fR \\fIcommand\\fR [\\fIoptions\\fR]\n" + ".SH DESCRIPTION\n" + plain(program.help) +
      "\nLengths are in meters. Results go to standard output, messages and progress to "
      "standard error.\n.SH OPTIONS\n";
  for (const OptionText& option : program.options) text += optionLine(option);
  text += ".SH COMMANDS\n";
  for (const CommandText& command : commands) text += commandSection(name, command);
  return text +
         ".SH EXIT STATUS\n"
         ".TP\n0\nDone.\n.TP\n1\nThe work failed, or a demo's own check did not hold.\n"
         ".TP\n2\nBad input: one line names the file or option and says what to do.\n"
         ".SH ENVIRONMENT\n"
         ".TP\n\\fBCLOUDCONTACT_CACHE\\fR\n"
         "The folder of clouds and surfaces that are kept between runs, or off. Without it, "
         "cloudcontact in \\fBXDG_CACHE_HOME\\fR or ~/.cache.\n";
}

}  // namespace cloudcontact::program
