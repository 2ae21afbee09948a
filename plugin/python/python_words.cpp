// Messages in Python's words (python_words.h).
#include "python/python_words.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <regex>

namespace cloudcontact::python {
namespace {

namespace py = pybind11;

// Names of what Python calls otherwise.
const std::map<std::string, std::string>& elements() {
  static const std::map<std::string, std::string> all = {
      {"mu", "friction"},        {"kp", "stiffness"},
      {"kd", "damping"},         {"restitution_coefficient", "restitution"},
      {"max_step_size", "step"}, {"collision", "shape"},
      {"scale", "unit"},         {"inertial", "mass"}};
  return all;
}

// Replaces what `pattern` matches by `word` of its first group.
template <typename Word>
std::string replaced(const std::string& text, const std::regex& pattern, const Word& word) {
  std::string made;
  auto last = text.begin();
  for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at) {
    made.append(last, text.begin() + at->position());
    made += word((*at)[1].str());
    last = text.begin() + at->position() + at->length();
  }
  return made.append(last, text.end());
}

// How many letters must be put in, left out or changed to make one word of the other.
std::size_t distanceOf(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t corner = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t changed = corner + (a[i] != b[j]);
      corner = row[j + 1];
      row[j + 1] = std::min({row[j] + 1, row[j + 1] + 1, changed});
    }
  }
  return row.back();
}

}  // namespace

std::string inPython(const std::string& message) {
  static const std::regex unit("--unit (mm|cm|in)\\b"), option("--([a-z][a-z-]*)"),
      setting("\\b(voxelSize|maxBytes)\\b");
  std::string text =
      replaced(message, unit, [](const std::string& name) { return "unit='" + name + "'"; });
  text = replaced(text, option, [](std::string name) {
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
  });
  return replaced(text, setting, [](const std::string& name) {
    return name == "maxBytes" ? std::string("max_bytes") : std::string("voxel");
  });
}

std::string ofScene(const std::string& message) {
  static const std::regex element("<(?:cloudcontact:)?([a-z_]+)(?: [^>]*)?>");
  return replaced(inPython(message), element, [](const std::string& name) {
    const auto known = elements().find(name);
    return known == elements().end() ? name : known->second;
  });
}

std::string unknownWord(const std::string& function, const std::string& word,
                        const std::vector<std::string>& known) {
  std::string message = function + "() got an unexpected keyword argument '" + word + "'";
  const auto nearest = std::min_element(
      known.begin(), known.end(),
      [&](const auto& a, const auto& b) { return distanceOf(word, a) < distanceOf(word, b); });
  if (nearest != known.end() && 2 * distanceOf(word, *nearest) <= word.size())
    return message + "; did you mean '" + *nearest + "'?";
  message += "; it takes ";
  for (const std::string& name : known) message += (&name == &known.front() ? "" : ", ") + name;
  return message;
}

std::function<py::object(py::object, py::args, py::kwargs)> takingWords(
    const std::string& name, std::vector<std::string> known) {
  return [name, known = std::move(known)](const py::object& self, const py::args& values,
                                          const py::kwargs& words) -> py::object {
    for (const auto& [key, value] : words) {
      const auto word = key.cast<std::string>();
      if (std::find(known.begin(), known.end(), word) == known.end())
        throw py::type_error(unknownWord(name, word, known));
    }
    try {
      return self.attr(("_" + name).c_str())(*values, **words);
    } catch (py::error_already_set& raised) {
      const std::string why = py::str(raised.value());
      if (!raised.matches(PyExc_TypeError) ||
          why.find("incompatible function arguments") == why.npos)
        throw;
      throw py::type_error(name +
                           "(): an argument is missing, too many, or of a wrong type; help() tells "
                           "which fit");
    }
  };
}

}  // namespace cloudcontact::python
