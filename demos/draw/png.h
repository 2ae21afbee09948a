// A drawing as the bytes of a PNG file, rasterised by Cairo.
#pragma once

#include <string>

#include "draw/drawing.h"

namespace cloudcontact::program {

// Pixels of the file per px of the drawing: twice as fine as a plain screen, so that small voxels
// and their arrows stay sharp where the picture is enlarged.
inline constexpr int kPixelsPerPx = 2;

// The same drawing gives the same bytes on one machine. Throws WorkFailed where Cairo cannot.
std::string pngBytes(const Drawing& drawing);

}  // namespace cloudcontact::program
