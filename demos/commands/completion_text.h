// Completion scripts for shells, from the commands that there are.
#pragma once

#include <string>
#include <vector>

#include "commands/command_tree.h"

namespace cloudcontact::program {

// `program`: its name and its own options.
std::string bashCompletion(const CommandText& program, const std::vector<CommandText>& commands);
std::string zshCompletion(const CommandText& program, const std::vector<CommandText>& commands);
std::string fishCompletion(const CommandText& program, const std::vector<CommandText>& commands);

}  // namespace cloudcontact::program
