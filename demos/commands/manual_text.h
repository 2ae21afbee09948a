// The manual page in roff, from the commands that there are.
#pragma once

#include <string>
#include <vector>

#include "commands/command_tree.h"

namespace cloudcontact::program {

std::string manualPage(const CommandText& program, const std::vector<CommandText>& commands);

}  // namespace cloudcontact::program
