// What the readers of files share: a name's extension, opening a file, and refusing it.
#pragma once

#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

namespace cloudcontact {

// With its dot, in lower case: ".stl".
inline std::string lowerExtension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

// Throws std::runtime_error: the file's name and why.
[[noreturn]] inline void refuseFile(const std::filesystem::path& file, const std::string& why) {
  throw std::runtime_error(file.string() + ": " + why);
}

// `kind`: what it should be, "a mesh file". Throws as refuseFile() where it cannot be read.
inline std::ifstream openFile(const std::filesystem::path& file, const std::string& kind) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) refuseFile(file, "no such file; check its name");
  if (!std::filesystem::is_regular_file(file, error))
    refuseFile(file, "is not a file; give " + kind);
  std::ifstream in(file, std::ios::binary);
  if (!in) refuseFile(file, "cannot be read; check its permissions");
  return in;
}

// All of it. Throws the same, and where it is empty.
inline std::string bytesOfFile(const std::filesystem::path& file, const std::string& kind) {
  std::ifstream in = openFile(file, kind);
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (bytes.empty()) refuseFile(file, "is empty; save it again");
  return bytes;
}

}  // namespace cloudcontact
