// A temporary that is renamed once it is whole, and removed on every other way out.
#include "io/whole_file.h"

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
