// Files of scenes before libsdformat reads them, and words of scenes (scene_text.h).
#include "scene/scene_text.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>
#include <system_error>
#include <vector>

#include "io/errors.h"
#include "io/text.h"

namespace cloudcontact::program {

bool isRobotFile(const std::filesystem::path& file) {
  return file.extension() == ".urdf";
}

std::string sceneText(const std::filesystem::path& file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored))
    throw BadInput(file.string() + ": is a directory; give a file in it");
  if (!std::filesystem::exists(file, ignored))
    throw BadInput(file.string() + ": no such file; give an SDFormat world");
  if (!std::filesystem::is_regular_file(file, ignored))
    throw BadInput(file.string() + ": is not a file; save the world as one");
  const std::string kind = isRobotFile(file) ? "robot" : "sdf";
  std::ifstream in(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) throw BadInput(file.string() + ": cannot be read; check its permissions");
  if (text.find("<" + kind) == std::string::npos)
    throw BadInput(file.string() + (isRobotFile(file)
                                        ? ": not a URDF file, it has no <robot>; give a robot"
                                        : ": not an SDFormat file, it has no <sdf>; give a "
                                          "world, or a robot as .urdf"));
  if (text.find("</" + kind + ">") == std::string::npos)
    throw BadInput(file.string() + ": cut short, </" + kind + "> is missing; get the whole file");
  return text;
}

std::array<bool, 6> sidesOf(const std::string& where, const std::string& text) {
  const std::vector<std::string> sides = {"-x", "+x", "-y", "+y", "-z", "+z"};
  std::array<bool, 6> held = {};
  std::istringstream list(text);
  for (std::string side; list >> side;) {
    const auto known = std::find(sides.begin(), sides.end(), side);
    if (known == sides.end())
      throw BadInput(where + ": " + printable(side) +
                     " is no side; give some of -x +x -y +y -z +z");
    held[static_cast<std::size_t>(known - sides.begin())] = true;
  }
  return held;
}

}  // namespace cloudcontact::program
