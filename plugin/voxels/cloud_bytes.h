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

template <typename Hash>
class HashedWriter {
 public:
  explicit HashedWriter(std::ostream& out) : out_(out) {}
  void bytes(const void* data, std::size_t count) {
    hash_.add(data, count);
    out_.write(static_cast<const char*>(data), static_cast<std::streamsize>(count));
  }
  template <typename Number>
  void number(Number x) {
    x = inFileOrder(x);
    bytes(&x, sizeof(x));
  }
  void checksum() { number(hash_.value()); }

 private:
  std::ostream& out_;
  Hash hash_;
};

// Throws std::runtime_error where the bytes end too early. `again`: what to do, "; save it again".
template <typename Hash>
class HashedReader {
 public:
  HashedReader(std::istream& in, const std::filesystem::path& file, const char* again)
      : in_(in), file_(file), again_(again) {}
  void bytes(void* data, std::size_t count) {
    in_.read(static_cast<char*>(data), static_cast<std::streamsize>(count));
    if (!in_) refuse("is cut short");
    hash_.add(data, count);
    read_ += count;
  }
  template <typename Number>
  Number number() {
    Number x;
    bytes(&x, sizeof(x));
    return inFileOrder(x);
  }
  // Reads it, at the end. Throws std::runtime_error where it does not match.
  void checksum() {
    const std::uint64_t expected = hash_.value();
    if (number<std::uint64_t>() != expected) refuse("is damaged: its checksum does not match");
  }
  std::uint64_t position() const { return read_; }  // bytes read so far
  [[noreturn]] void refuse(const std::string& why) const { refuseFile(file_, why + again_); }

 private:
  std::istream& in_;
  const std::filesystem::path& file_;
  const char* again_;
  Hash hash_;
  std::uint64_t read_ = 0;
};

constexpr char kCloudAgain[] = "; save the cloud again";
using CloudWriter = HashedWriter<Fnv1a>;
using CloudReader = HashedReader<Fnv1a>;

// Calls write(stream) for a temporary file beside `file`, then renames it. Throws
// std::runtime_error and removes the temporary file where any of that fails.
void writeWhole(const std::filesystem::path& file, const std::function<void(std::ostream&)>& write);

// Throws std::runtime_error unless the file's `length` is what its header says. `again`: what to
// do, "; save it again".
void checkLength(const std::filesystem::path& file, std::uint64_t length, std::uint64_t expected,
                 const std::string& again);

// Reads the magic word and the version. Throws std::runtime_error where the file is not a cloud or
// of another version than the three above.
std::uint32_t readCloudVersion(CloudReader& reader, const std::filesystem::path& file);

}  // namespace cloudcontact
