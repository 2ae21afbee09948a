// Picks the format by extension and writes the file.
#include "replay/replay_file.h"

#include "io/output_file.h"
#include "replay/gltf.h"
#include "replay/page.h"

namespace cloudcontact::program {

namespace {

constexpr const char* kOption = "--replay";

}  // namespace

void checkReplay(const std::string& file) {
  checkOutput(kOption, file, {".glb", ".html"});
}

void saveReplay(const Replay& replay, const std::string& file) {
  const bool page = file.ends_with(".html");
  writeWhole(kOption, file, page ? pageBytes(replay) : gltfBytes(replay));
}

}  // namespace cloudcontact::program
