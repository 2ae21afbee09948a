// Files that the program writes: whole or not at all.
#pragma once

#include <string>
#include <vector>

namespace cloudcontact::program {

// Throws BadInput naming `option` where `file` cannot be written or ends in none of `extensions`:
// before the work rather than after it.
void checkOutput(const std::string& option, const std::string& file,
                 const std::vector<std::string>& extensions);

// Writes a temporary beside `file`, then gives it its name; whatever goes wrong leaves what was
// there before and nothing else. Throws BadInput naming `option` where the file cannot be opened,
// WorkFailed where it cannot be filled (a full disk is nothing that the input could mend).
void writeWhole(const std::string& option, const std::string& file, const std::string& bytes);

}  // namespace cloudcontact::program
