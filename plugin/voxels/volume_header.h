// The headers of volume files: where the values are, their type and their places.
#pragma once

#include <cloudcontact/base/pose.h>

#include <cstdint>
#include <filesystem>
#include <string>

namespace cloudcontact {

enum class ValueType { I8, U8, I16, U16, I32, U32, I64, U64, F32, F64 };
std::size_t bytesOf(ValueType type);

struct VolumeHeader {
  std::filesystem::path data;  // the file with the values
  std::int64_t skip = 0;       // bytes before them; -1: they are the last bytes
  bool isZipped = false;       // by gzip or zlib
  bool isBigEndian = false;
  ValueType type = ValueType::I16;
  Eigen::Vector3i size = Eigen::Vector3i::Zero();       // values along the file's axes
  Eigen::Matrix3d axes = Eigen::Matrix3d::Constant(0);  // columns: from a value to its neighbor
  Vec3 first = Vec3::Zero();                            // center of the first value
  double metersPerUnit = 0;                             // of axes and first; 0: not stated
};

// Both throw std::runtime_error as loadVolume() does.
VolumeHeader readNrrdHeader(const std::filesystem::path& file);
VolumeHeader readMetaImageHeader(const std::filesystem::path& file);

}  // namespace cloudcontact
