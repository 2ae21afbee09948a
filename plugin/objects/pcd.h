// The PCD format of the Point Cloud Library, versions .6 and .7, text and binary.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace cloudcontact {

struct PcdPoints {
  int width = 0, height = 0;  // height 1: in no order
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> positions;  // as the file has them, NaN and all
  std::vector<Eigen::Vector3d> normals;    // empty where it has none
};

// What is wrong with the bytes of such a file, or nothing: then `points` is what it holds.
std::string readPcd(std::string_view bytes, PcdPoints& points);

}  // namespace cloudcontact
