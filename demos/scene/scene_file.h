// Reads scenes from SDFormat and URDF files.
#pragma once

#include <filesystem>

#include "scene/scene.h"

namespace cloudcontact::program {

// Reads the only world of an SDFormat file, or the robot of a file that ends in .urdf; mesh paths
// are relative to the file. Throws BadInput naming the file and the element if the file is
// unreadable, not SDFormat or has no world, if a geometry, a joint or an element of our own is not
// supported, or if a value is not finite or not positive.
SceneDescription loadScene(const std::filesystem::path& file);

// The robot of a URDF text that names no files.
SceneDescription robotOf(const std::string& name, const std::string& text);

}  // namespace cloudcontact::program
