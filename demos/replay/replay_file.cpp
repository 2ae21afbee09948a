// Which of the two formats, and the way to the disk.
#include "replay/replay_file.h"

#include <filesystem>

#include "errors.h"
#include "json.h"
#include "replay/gltf.h"
#include "replay/page.h"
#include "whole_file.h"

namespace cloudcontact::program {

namespace {

constexpr const char* kOption = "--replay";

std::string extensionOf(const std::string& file) {
  return std::filesystem::path(file).extension().string();
}

}  // namespace

void checkReplay(const std::string& file) {
  const std::string extension = extensionOf(file);
  if (extension != ".glb" && extension != ".html")
    throw BadInput(std::string(kOption) + ": '" + file +
                   "' ends in neither .glb nor .html; name it FILE.glb or FILE.html");
  checkOutput(kOption, file, "");
}

void saveReplay(const Replay& replay, const std::string& file) {
  const bool page = extensionOf(file) == ".html";
  writeWhole(kOption, file, page ? pageBytes(replay) : gltfBytes(replay));
}

}  // namespace cloudcontact::program
