// The picture of a cut body: the remaining body from outside, and two slices through the cut, with
// materials in color and the removed part in pale.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "draw/drawing.h"

namespace cloudcontact::program {

struct CutPictureText {
  std::string title, below;
  std::vector<std::string> names;  // of the materials, if not the cloud's own
  bool opened = false;             // leaves out the half in front of the cut's middle (y)
};

// `before` and `after` must have the same grid; throws std::invalid_argument otherwise.
Drawing cutPicture(const Cloud& before, const Cloud& after, const CutPictureText& words);

}  // namespace cloudcontact::program
