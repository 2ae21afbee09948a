// URDF robots as libsdformat needs them.
#pragma once

#include <set>
#include <string>

namespace cloudcontact::program {

// libsdformat leaves a link without a mass out, and all that hangs on it, without a word.
struct RobotText {
  std::string text;                // with a mass of 1 kg for the links that had none
  std::set<std::string> standIns;  // these links: their mass is yet to come from their voxels
};

// From the text of a URDF file; unchanged where nothing is missing or where it is no XML. Throws
// std::invalid_argument that names the link if a link that joints move or hold has neither a mass
// nor a collision.
RobotText withMasses(const std::string& text);

}  // namespace cloudcontact::program
