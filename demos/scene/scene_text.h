// The text of a scene's file, and words in it.
#pragma once

#include <array>
#include <filesystem>
#include <string>

namespace cloudcontact::program {

// By its name: a URDF robot, else an SDFormat world.
bool isRobotFile(const std::filesystem::path& file);

// Throws BadInput that names the cause for files that are missing, cut short or something else, of
// which libsdformat only says that it cannot read them.
std::string sceneText(const std::filesystem::path& file);

// Sides of a body's bounds, as "-z" or "-x +x", in the order -x +x -y +y -z +z. Throws BadInput
// that begins with `where`.
std::array<bool, 6> sidesOf(const std::string& where, const std::string& text);

}  // namespace cloudcontact::program
