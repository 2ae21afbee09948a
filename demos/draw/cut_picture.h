// The picture of a body that was cut: what is left from outside, and two slices through the cut
// with every material in its colour and what went faintly behind.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "draw/drawing.h"

namespace cloudcontact::program {

struct CutPictureWords {
  std::string title, below;
  std::vector<std::string> names;  // of the materials, where not the cloud's own
  bool opened = false;  // the view from outside without what lies before the cut's middle (y)
};

// `before` and `after` are of one grid; throws std::invalid_argument where they are not.
Drawing cutPicture(const Cloud& before, const Cloud& after, const CutPictureWords& words);

}  // namespace cloudcontact::program
