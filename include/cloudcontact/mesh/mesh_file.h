// Meshes from files, through Assimp: STL, OBJ, PLY, glTF and what else it reads.
// Part of the target CloudContact::files, so that the core needs nothing but Eigen.
#pragma once

#include <cloudcontact/mesh/mesh.h>

#include <filesystem>

namespace cloudcontact {

// All meshes of the file in one, node transforms applied, in metres: file coordinates times
// `metresPerUnit`. Throws std::runtime_error that names the file and says what is wrong: it is
// missing, empty, no mesh, has no triangles, has NaN or infinite vertices, or is cut short.
Mesh loadMesh(const std::filesystem::path& file, double metresPerUnit = 1.0);

// The same, part by part: the file's objects or groups, those of one name together, in the order of
// the file. A part without a name is called "part 1" and so on.
std::vector<NamedMesh> loadMeshParts(const std::filesystem::path& file, double metresPerUnit = 1.0);

}  // namespace cloudcontact
