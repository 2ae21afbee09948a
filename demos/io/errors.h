// The two ways in which a command ends badly, and what main() makes of them.
#pragma once

#include <stdexcept>

namespace cloudcontact::program {

// The input cannot be used: one line that names the file or option and says what to do. Exit 2.
class BadInput : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The input was good, yet the work failed (a demo's own check did not hold). Exit 1.
class WorkFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace cloudcontact::program
