// Picks the format by extension and writes the file.
#include "draw/picture_file.h"

#include "draw/png.h"
#include "draw/svg.h"
#include "io/output_file.h"

namespace cloudcontact::program {

namespace {

constexpr const char* kOption = "--picture";

}  // namespace

void checkPicture(const std::string& file) {
  checkOutput(kOption, file, {".png", ".svg"});
}

void savePicture(const Drawing& drawing, const std::string& file) {
  const bool svg = file.ends_with(".svg");
  writeWhole(kOption, file, svg ? svgText(drawing) : pngBytes(drawing));
}

}  // namespace cloudcontact::program
