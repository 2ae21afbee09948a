// The temporary file is renamed once it is complete, and removed otherwise.
#include "io/output_file.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <utility>

#include "io/errors.h"

namespace cloudcontact::program {

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

OutputFile::OutputFile(std::string option, std::string file)
    : option_(std::move(option)),
      file_(std::move(file)),
      temporary_(file_ + "." + std::to_string(std::random_device()()) + ".part"),
      out_(temporary_, std::ios::binary) {
  if (!out_) throw BadInput(option_ + ": " + file_ + " cannot be written; choose another folder");
}

OutputFile::~OutputFile() {
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
}

void OutputFile::add(const std::string& bytes) {
  out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

void OutputFile::finish() {
  out_.close();
  if (!out_)
    throw WorkFailed(option_ + ": " + file_ +
                     " could not be written whole; check the space that is left");
  std::error_code error;
  std::filesystem::rename(temporary_, file_, error);
  if (error)
    throw BadInput(option_ + ": " + file_ + " cannot be replaced (" + error.message() +
                   "); choose another name");
}

void writeWhole(const std::string& option, const std::string& file, const std::string& bytes) {
  OutputFile out(option, file);
  out.add(bytes);
  out.finish();
}

}  // namespace cloudcontact::program
