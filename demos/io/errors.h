// The two exceptions that end a command, and their exit codes.
#pragma once

#include <stdexcept>

namespace cloudcontact::program {

// Unusable input. The message is one line that names the file or option and says what to do. Exit
// code 2.
class BadInput : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The input is good but the work fails, such as a demo's check or a write to a full disk. Exit code
// 1.
class WorkFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace cloudcontact::program
