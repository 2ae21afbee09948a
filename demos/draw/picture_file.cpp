// Which of the two formats, and the way to the disk.
#include "draw/picture_file.h"

#include <filesystem>

#include "draw/png.h"
#include "draw/svg.h"
#include "errors.h"
#include "json.h"
#include "whole_file.h"

namespace cloudcontact::program {

namespace {

constexpr const char* kOption = "--picture";

std::string extensionOf(const std::string& file) {
  return std::filesystem::path(file).extension().string();
}

}  // namespace

void checkPicture(const std::string& file) {
  const std::string extension = extensionOf(file);
  if (extension != ".png" && extension != ".svg")
    throw BadInput(std::string(kOption) + ": '" + file +
                   "' ends in neither .png nor .svg; name it FILE.png or FILE.svg");
  checkOutput(kOption, file, "");
}

void savePicture(const Drawing& drawing, const std::string& file) {
  const bool svg = extensionOf(file) == ".svg";
  writeWhole(kOption, file, svg ? svgText(drawing) : pngBytes(drawing));
}

}  // namespace cloudcontact::program
