// The PCD format of the Point Cloud Library, versions .6 and .7, text and binary.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace cloudcontact {

struct PcdPoints {
  int width = 0, height = 0;  // height 1: unordered points
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> positions;  // may be NaN
  std::vector<Eigen::Vector3d> normals;    // empty where the file has none
};

// Reads the bytes of such a file into `points`. Returns the fault; empty where there is none.
std::string readPcd(std::string_view bytes, PcdPoints& points);

}  // namespace cloudcontact
