// Vectors as JSON, and the look at an output file before the work starts.
#include "io/json.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "io/errors.h"

namespace cloudcontact::program {

std::string jsonText(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

Json asJson(const Eigen::Vector3d& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

Json asJson(const Eigen::Matrix3d& m) {
  Json numbers = Json::array();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) numbers.push_back(m(row, column));
  return numbers;
}

std::string vectorText(const Json& array) {
  std::ostringstream text;
  for (std::size_t k = 0; k < array.size(); ++k) text << (k ? " " : "") << array[k].get<double>();
  return text.str();
}

void checkOutput(const std::string& option, const std::string& file,
                 const std::vector<std::string>& extensions) {
  namespace fs = std::filesystem;
  const fs::path path(file);
  std::error_code error;
  const auto refuse = [&](const std::string& why) {
    throw BadInput(option + ": " + file + " " + why);
  };
  if (std::find(extensions.begin(), extensions.end(), path.extension()) == extensions.end()) {
    const bool one = extensions.size() == 1;
    std::string ends, names;
    for (const std::string& extension : extensions) {
      ends += (ends.empty() ? "" : " nor ") + extension;
      names += (names.empty() ? "FILE" : " or FILE") + extension;
    }
    refuse((one ? "does not end in " : "ends in neither ") + ends + "; name the file " + names);
  }
  if (fs::is_directory(path, error)) refuse("is a directory; name a file in it");
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error))
    refuse("cannot be written, its folder does not exist; make it first");
  // Asked by trying: to root every folder looks writable, also where none can write.
  const std::string trial = file + "." + std::to_string(getpid()) + ".part";
  const bool written = std::ofstream(trial).good();
  fs::remove(trial, error);
  if (!written) refuse("cannot be written, its folder is not writable; choose another");
}

}  // namespace cloudcontact::program
