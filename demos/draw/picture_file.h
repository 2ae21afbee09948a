// `--picture FILE`: saves a drawing as PNG or SVG, by the file's extension.
#pragma once

#include <string>

#include "draw/drawing.h"

namespace cloudcontact::program {

// Throws BadInput naming --picture if `file` ends in neither .png nor .svg or cannot be written.
// Call it before the work starts.
void checkPicture(const std::string& file);

// Writes the file whole or not at all. Throws BadInput or WorkFailed naming it.
void savePicture(const Drawing& drawing, const std::string& file);

}  // namespace cloudcontact::program
