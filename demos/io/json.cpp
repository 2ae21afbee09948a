// Vectors as JSON, and JSON as text.
#include "io/json.h"

#include <sstream>

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

}  // namespace cloudcontact::program
