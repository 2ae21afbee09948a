// Input and output of `.cloud` files: little-endian numbers with a checksum over all bytes, and
// files that are complete or absent.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "base/byte_archive.h"
#include "base/file_name.h"
#include "base/hash.h"

namespace cloudcontact {

constexpr char kCloudMagic[8] = {'C', 'L', 'D', 'C', 'N', 'T', 'C', 'T'};
// Versions: voxels, voxels of several materials, any kind of object.
constexpr std::uint32_t kPlainCloud = 1, kCloudWithMaterials = 2, kAnyObject = 3;

class CloudWriter {
 public:
  explicit CloudWriter(std::ostream& out) : out_(out) {}
  void bytes(const void* data, std::size_t count) {
    hash_.add(data, count);
    out_.write(static_cast<const char*>(data), static_cast<std::streamsize>(count));
  }
  template <typename Number>
  void number(Number x) {
    x = inFileOrder(x);
    bytes(&x, sizeof(x));
  }
  std::uint64_t hash() const { return hash_.value(); }

 private:
  std::ostream& out_;
  Fnv1a hash_;
};

class CloudReader {
 public:
  CloudReader(std::istream& in, const std::filesystem::path& file) : in_(in), file_(file) {}
  void bytes(void* data, std::size_t count) {
    in_.read(static_cast<char*>(data), static_cast<std::streamsize>(count));
    if (!in_) refuseFile(file_, "is cut short; save the cloud again");
    hash_.add(data, count);
  }
  template <typename Number>
  Number number() {
    Number x;
    bytes(&x, sizeof(x));
    return inFileOrder(x);
  }
  std::uint64_t hash() const { return hash_.value(); }
  const std::filesystem::path& file() const { return file_; }

 private:
  std::istream& in_;
  const std::filesystem::path& file_;
  Fnv1a hash_;
};

// Calls write(stream) for a temporary file beside `file`, then renames it. Throws
// std::runtime_error and removes the temporary file where any of that fails.
void writeWhole(const std::filesystem::path& file, const std::function<void(std::ostream&)>& write);

// Throws std::runtime_error unless the file's `length` is what its header says. `again`: what to
// do, "; save it again".
void checkLength(const std::filesystem::path& file, std::uint64_t length, std::uint64_t expected,
                 const std::string& again);

// Reads the magic word and the version. Throws std::runtime_error where the file is not a cloud or
// of another version than the three above.
std::uint32_t readCloudVersion(CloudReader& reader);

// Reads the checksum at the end. Throws std::runtime_error where it does not match.
void checkCloudHash(CloudReader& reader);

}  // namespace cloudcontact
