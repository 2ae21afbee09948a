// The text of a scene's file.
#pragma once

#include <filesystem>
#include <string>

namespace cloudcontact::program {

// By its name: a URDF robot, else an SDFormat world.
bool isRobotFile(const std::filesystem::path& file);

// Throws BadInput that names the cause for files that are missing, cut short or something else, of
// which libsdformat only says that it cannot read them.
std::string sceneText(const std::filesystem::path& file);

}  // namespace cloudcontact::program
