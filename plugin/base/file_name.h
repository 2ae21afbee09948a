// What the readers of files share: a name's extension, and the refusal of a file.
#pragma once

#include <cctype>
#include <filesystem>
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

}  // namespace cloudcontact
