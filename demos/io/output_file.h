// Output files: checked before the work starts, and written whole or not at all.
#pragma once

#include <string>
#include <vector>

namespace cloudcontact::program {

// Throws BadInput naming `option` if `file` cannot be written or has none of `extensions`. Call it
// before the work starts.
void checkOutput(const std::string& option, const std::string& file,
                 const std::vector<std::string>& extensions);

// Writes a temporary file next to `file` and renames it. On failure the old file stays and no
// temporary is left. Throws BadInput naming `option` if the file cannot be opened, WorkFailed if
// writing fails (a full disk).
void writeWhole(const std::string& option, const std::string& file, const std::string& bytes);

}  // namespace cloudcontact::program
