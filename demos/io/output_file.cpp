// The temporary file is renamed once it is complete, and removed otherwise.
#include "io/output_file.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>

#include "io/errors.h"

namespace cloudcontact::program {

namespace {

class Temporary {
 public:
  explicit Temporary(const std::string& target)
      : path_(target + "." + std::to_string(std::random_device()()) + ".part") {}
  ~Temporary() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace

void checkOutput(const std::string& option, const std::string& file,
                 const std::vector<std::string>& extensions) {
  namespace fs = std::filesystem;
  const fs::path path(file);
  std::error_code error;
  const auto refuse = [&](const std::string& why) {
    throw BadInput(option + ": " + file + " " + why);
  };
  if (std::find(extensions.begin(), extensions.end(), path.extension()) == extensions.end()) {
    const bool one = extensions.size() == 1;
    std::string ends, names;
    for (const std::string& extension : extensions) {
      ends += (ends.empty() ? "" : " nor ") + extension;
      names += (names.empty() ? "FILE" : " or FILE") + extension;
    }
    refuse((one ? "does not end in " : "ends in neither ") + ends + "; name the file " + names);
  }
  if (fs::is_directory(path, error)) refuse("is a directory; name a file in it");
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error))
    refuse("cannot be written, its folder does not exist; make it first");
  // Tries to write a file, because to root every folder looks writable.
  const std::string trial = file + "." + std::to_string(getpid()) + ".part";
  const bool written = std::ofstream(trial).good();
  fs::remove(trial, error);
  if (!written) refuse("cannot be written, its folder is not writable; choose another");
}

void writeWhole(const std::string& option, const std::string& file, const std::string& bytes) {
  const Temporary temporary(file);
  std::ofstream out(temporary.path(), std::ios::binary);
  if (!out) throw BadInput(option + ": " + file + " cannot be written; choose another folder");
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out)
    throw WorkFailed(option + ": " + file +
                     " could not be written whole; check the space that is left");
  std::error_code error;
  std::filesystem::rename(temporary.path(), file, error);
  if (error)
    throw BadInput(option + ": " + file + " cannot be replaced (" + error.message() +
                   "); choose another name");
}

}  // namespace cloudcontact::program
