// Checks of STL and PLY files before Assimp parses them. Assimp accepts truncated files, loops on a
// PLY header without an end and reads past the end of short binary data.
#pragma once

#include <string>
#include <string_view>

namespace cloudcontact {

// Whether files of this extension (lower case, with its dot) are checked: .stl and .ply.
bool isCheckedMeshFile(std::string_view extension);

// The fault in the bytes of such a file; empty where there is none.
std::string faultOfMeshFile(std::string_view bytes, std::string_view extension);

}  // namespace cloudcontact
