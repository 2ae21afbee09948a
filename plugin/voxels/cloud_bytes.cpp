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

void refuseCloudFile(const fs::path& file, const std::string& why) {
  throw std::runtime_error(file.string() + ": " + why);
}

void writeWhole(const fs::path& file, const std::function<void(std::ostream&)>& write) {
  if (fs::is_directory(file)) refuseCloudFile(file, "is a directory; give the name of a file");
  const Temporary temporary(file);
  std::ofstream out(temporary.path(), std::ios::binary);
  if (!out)
    refuseCloudFile(file, "cannot be written; check that its folder exists and may be written to");
  write(out);
  out.close();
  if (!out) refuseCloudFile(file, "could not be written whole; check the space that is left");
  std::error_code error;
  fs::rename(temporary.path(), file, error);
  if (error) refuseCloudFile(file, "cannot be replaced: " + error.message());
}

std::ifstream openCloudFile(const fs::path& file) {
  if (!fs::exists(file)) refuseCloudFile(file, "no such file");
  if (!fs::is_regular_file(file)) refuseCloudFile(file, "is not a file; give a .cloud file");
  std::ifstream in(file, std::ios::binary);
  if (!in) refuseCloudFile(file, "cannot be read; check its permissions");
  return in;
}

std::uint32_t readCloudVersion(CloudReader& reader) {
  char magic[sizeof(kCloudMagic)];
  reader.bytes(magic, sizeof(magic));
  if (std::memcmp(magic, kCloudMagic, sizeof(magic)) != 0)
    refuseCloudFile(reader.file(), "is not a cloud; make one with `cloudcontact digitize`");
  const auto version = reader.number<std::uint32_t>();
  if (version < kPlainCloud || version > kAnyObject)
    refuseCloudFile(reader.file(), "is a cloud of version " + std::to_string(version) +
                                       ", this program reads 1 to 3; digitize the body again");
  return version;
}

void checkCloudHash(CloudReader& reader) {
  const std::uint64_t hash = reader.hash();
  if (reader.number<std::uint64_t>() != hash)
    refuseCloudFile(reader.file(), "is damaged: its bytes do not add up; save the cloud again");
}

}  // namespace cloudcontact
