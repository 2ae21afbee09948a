// What must hold of a mesh file before a parser may see it. Assimp reads cut-short STL and PLY
// files as if they were whole, loops on a PLY header without an end and reads beyond short binary
// data.
#pragma once

#include <string>
#include <string_view>

namespace cloudcontact {

// Whether files of this extension (with its dot, in lower case) are checked: .stl and .ply.
bool isCheckedMeshFile(std::string_view extension);

// What is wrong with the bytes of such a file, or nothing.
std::string faultOfMeshFile(std::string_view bytes, std::string_view extension);

}  // namespace cloudcontact
