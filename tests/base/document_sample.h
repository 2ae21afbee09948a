// Code in documents. A test compiles and runs it between the marks `// NAME begins` and `// NAME
// ends`, and the document shows exactly these lines as ```cpp NAME. script/check_house finds code
// in documents that no test shows.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>

namespace cloudcontact::testing {

// The lines of a file of this repository after the one that is `begin` but for its indentation, up
// to the one that is `end`, less that indentation (a line with less loses what it has).
inline std::string linesBetween(const std::string& file, const std::string& begin,
                                const std::string& end) {
  std::ifstream in(std::string(CLOUDCONTACT_SOURCE_DIR) + "/" + file);
  std::string lines;
  std::size_t indent = std::string::npos;
  for (std::string line; std::getline(in, line);) {
    const std::size_t first = line.find_first_not_of(' ');
    const std::string bare = first == std::string::npos ? "" : line.substr(first);
    if (indent == std::string::npos) {
      if (bare == begin) indent = first;
    } else if (bare == end) {
      return lines;
    } else {
      lines += line.substr(std::min({indent, first, line.size()})) + "\n";
    }
  }
  return "no '" + begin + "' or no '" + end + "' after it in " + file;
}

// Expects that the document shows the sample as the test has it.
inline void expectSample(const std::string& document, const std::string& name,
                         const std::string& test) {
  EXPECT_EQ(linesBetween(document, "```cpp " + name, "```"),
            linesBetween(test, "// " + name + " begins", "// " + name + " ends"))
      << document << " and " << test;
}

}  // namespace cloudcontact::testing
