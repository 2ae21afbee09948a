// Files that the program writes: whole or not at all.
#pragma once

#include <string>

namespace cloudcontact::program {

// Writes a temporary beside `file`, then gives it its name; whatever goes wrong leaves what was
// there before and nothing else. Throws BadInput naming `option` where the file cannot be opened,
// WorkFailed where it cannot be filled (a full disk is nothing that the input could mend).
void writeWhole(const std::string& option, const std::string& file, const std::string& bytes);

}  // namespace cloudcontact::program
