// `--picture FILE`: a drawing kept as PNG or SVG, whichever the file's name asks for.
#pragma once

#include <string>

#include "draw/drawing.h"

namespace cloudcontact::program {

// Throws BadInput naming --picture where `file` ends in neither .png nor .svg or cannot be
// written: before the work rather than after it.
void checkPicture(const std::string& file);

// Writes the file whole or not at all. Throws BadInput or WorkFailed naming it.
void savePicture(const Drawing& drawing, const std::string& file);

}  // namespace cloudcontact::program
