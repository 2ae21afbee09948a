// How the program writes: JSON fields in the order they are set, vectors as arrays, files checked
// before the work starts.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>

namespace cloudcontact::program {

using Json = nlohmann::ordered_json;

Json asJson(const Eigen::Vector3d& v);  // [x, y, z]
Json asJson(const Eigen::Matrix3d& m);  // 9 numbers, row by row

// "x y z" of an array, for people.
std::string vectorText(const Json& array);

// As text: indented where `indent` is not negative. Names come from files; what is not UTF-8 in
// them is replaced.
std::string jsonText(const Json& json, int indent = 2);

}  // namespace cloudcontact::program
