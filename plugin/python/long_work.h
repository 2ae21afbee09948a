// Work that takes long: without Python's lock, with progress, ended by Ctrl-C.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "python/numpy_views.h"

namespace cloudcontact::python {

// Runs `work` in a thread of its own. The calling thread meanwhile passes on what `work` reports
// (0..1) to Python's reporter(progress, label) of _progress.py, and listens to Ctrl-C. An exception
// that comes of either ends the work at its next report. Call it with Python's lock held. Throws
// what `work` throws.
void runLong(const py::object& progress, const std::string& label,
             const std::function<void(const std::function<void(double)>& report)>& work);

// What a loop of short steps in the calling thread asks after each: whether it is time to look at
// Ctrl-C and to report.
class Pacer {
 public:
  // Python's reporter(progress, label).
  Pacer(const py::object& progress, const std::string& label);
  // Call it without Python's lock. Throws what Python raised.
  void report(double share);
  // At the end, with Python's lock.
  void finish();

 private:
  py::object reporter_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace cloudcontact::python
