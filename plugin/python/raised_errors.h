// What C++ throws, as Python's exceptions.
#pragma once

#include <string>

#include "python/numpy_views.h"

namespace cloudcontact::python {

// Text that may hold a file's name in bytes that are no UTF-8: Python's own names for such files.
py::str textOf(const std::string& text);

// From now on. pybind11's own raises an exception without a word where a message is no UTF-8, and a
// RuntimeError about C++ where an argument is of a wrong type.
void registerErrors();

}  // namespace cloudcontact::python
