// Renders a drawing to the bytes of a PNG file with Cairo.
#pragma once

#include <string>

#include "draw/drawing.h"

namespace cloudcontact::program {

// Pixels of the file per px of the drawing, so that small voxels and arrows stay sharp when
// enlarged.
inline constexpr int kPixelsPerPx = 2;

// Deterministic on one machine. Throws WorkFailed if Cairo fails.
std::string pngBytes(const Drawing& drawing);

}  // namespace cloudcontact::program
