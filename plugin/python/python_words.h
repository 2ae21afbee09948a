// The library's and the program's messages in Python's words, and keywords that nobody knows.
#pragma once

#include <pybind11/functional.h>
#include <pybind11/pybind11.h>

#include <functional>
#include <string>
#include <vector>

namespace cloudcontact::python {

// Options of the command line as keywords: --max-bytes is max_bytes; settings of C++ likewise.
std::string inPython(const std::string& message);
// Elements of a scene file as keywords of Scene.add(), too: <mu> is friction.
std::string ofScene(const std::string& message);

// The message for a keyword that is not among the known.
std::string unknownWord(const std::string& function, const std::string& word,
                        const std::vector<std::string>& known);

// A method that passes its arguments on to the one of the same name with a `_` before it. A keyword
// that is not among the known is a TypeError that names it and the nearest; where pybind11 finds
// that arguments do not fit, it does not list all of them.
std::function<pybind11::object(pybind11::object, pybind11::args, pybind11::kwargs)> takingWords(
    const std::string& name, std::vector<std::string> known);

}  // namespace cloudcontact::python
