// JSON with its fields in the order they are set, and vectors as arrays.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>

namespace cloudcontact::program {

using Json = nlohmann::ordered_json;

Json asJson(const Eigen::Vector3d& v);  // [x, y, z]
Json asJson(const Eigen::Matrix3d& m);  // 9 numbers, row by row

// "x y z" from an array, for text output.
std::string vectorText(const Json& array);

// `json` as text, on one line if `indent` is negative. Replaces invalid UTF-8, which names from
// files may hold.
std::string jsonText(const Json& json, int indent = 2);

}  // namespace cloudcontact::program
