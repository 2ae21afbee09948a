// Python's lock given up for work that needs no Python, and taken again, however the process ends.
//
// py::gil_scoped_release ends the process with an error where the interpreter ends meanwhile:
// Python then ends the thread inside its destructor. So the interpreter waits with its end until
// nobody is in a scope of the classes below, and a thread that enters one meanwhile stops there for
// good.
#pragma once

#include <pybind11/pybind11.h>

namespace cloudcontact::python {

// True in all threads but the main one when the interpreter waits with its end. Long work then ends
// at the next occasion.
bool interpreterEnds();

// While it lives, the interpreter waits, and this thread does not stop in other scopes: for what
// others wait for.
class Claim {
 public:
  Claim();
  ~Claim();
  Claim(const Claim&) = delete;
  Claim& operator=(const Claim&) = delete;
};

// Gives up the lock of this thread until the end of the scope.
class Unlocked {
 public:
  Unlocked();
  ~Unlocked();
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

 private:
  Claim claim_;
  PyThreadState* state_;
};

// Takes the lock within such a scope, for as long as it lives.
class Locked {
 public:
  Locked();

 private:
  pybind11::gil_scoped_acquire locked_;
};

// Makes the interpreter wait. Call it once, with the lock.
void waitAtExit();

}  // namespace cloudcontact::python
