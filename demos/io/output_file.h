// Output files: checked before the work starts, and written whole or not at all.
#pragma once

#include <fstream>
#include <string>
#include <vector>

namespace cloudcontact::program {

// Throws BadInput naming `option` if `file` cannot be written or has none of `extensions`. Call it
// before the work starts.
void checkOutput(const std::string& option, const std::string& file,
                 const std::vector<std::string>& extensions);

// A file that is written bit by bit to a temporary next to it, which is renamed at the end. Without
// finish(), and on failure, the old file stays and no temporary is left.
class OutputFile {
 public:
  // Throws BadInput naming `option` if the file cannot be opened.
  OutputFile(std::string option, std::string file);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void add(const std::string& bytes);
  // Throws WorkFailed if something could not be written (a full disk), now or before, and BadInput
  // if the old file cannot be replaced.
  void finish();

 private:
  std::string option_, file_, temporary_;
  std::ofstream out_;
};

// An OutputFile of these bytes.
void writeWhole(const std::string& option, const std::string& file, const std::string& bytes);

}  // namespace cloudcontact::program
