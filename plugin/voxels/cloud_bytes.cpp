// Writes whole files and verifies them on reading: see cloud_bytes.h.
#include "voxels/cloud_bytes.h"

#include <cstring>
#include <random>
#include <stdexcept>

namespace cloudcontact {

namespace fs = std::filesystem;

namespace {

// Removes the temporary file unless it was renamed.
class Temporary {
 public:
  explicit Temporary(const fs::path& target) : path_(target) {
    path_ += ".";
    path_ += std::to_string(std::random_device()());
    path_ += ".part";
  }
  ~Temporary() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

void writeWhole(const fs::path& file, const std::function<void(std::ostream&)>& write) {
  if (fs::is_directory(file)) refuseFile(file, "is a directory; give the name of a file");
  const Temporary temporary(file);
  std::ofstream out(temporary.path(), std::ios::binary);
  if (!out)
    refuseFile(file, "cannot be written; check that its folder exists and may be written to");
  write(out);
  out.close();
  if (!out) refuseFile(file, "could not be written whole; check the space that is left");
  std::error_code error;
  fs::rename(temporary.path(), file, error);
  if (error) refuseFile(file, "cannot be replaced: " + error.message());
}

void checkLength(const fs::path& file, std::uint64_t length, std::uint64_t expected,
                 const std::string& again) {
  if (length < expected)
    refuseFile(file, "is cut short: " + std::to_string(length) + " bytes instead of " +
                         std::to_string(expected) + again);
  if (length > expected)
    refuseFile(file, "has " + std::to_string(length - expected) + " bytes too many" + again);
}

std::uint32_t readCloudVersion(CloudReader& reader) {
  char magic[sizeof(kCloudMagic)];
  reader.bytes(magic, sizeof(magic));
  if (std::memcmp(magic, kCloudMagic, sizeof(magic)) != 0)
    refuseFile(reader.file(), "is not a cloud; make one with `cloudcontact digitize`");
  const auto version = reader.number<std::uint32_t>();
  if (version < kPlainCloud || version > kAnyObject)
    refuseFile(reader.file(), "is a cloud of version " + std::to_string(version) +
                                  ", this program reads 1 to 3; digitize the body again");
  return version;
}

void checkCloudHash(CloudReader& reader) {
  const std::uint64_t hash = reader.hash();
  if (reader.number<std::uint64_t>() != hash)
    refuseFile(reader.file(), "is damaged: its bytes do not add up; save the cloud again");
}

}  // namespace cloudcontact
