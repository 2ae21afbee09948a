// Meshes from files, read by Assimp: STL, OBJ, PLY, glTF and its other formats. Part of the target
// CloudContact::files, so that the core depends on Eigen alone.
#pragma once

#include <cloudcontact/mesh/mesh.h>

#include <filesystem>

namespace cloudcontact {

// All meshes of a file as one, with node transforms applied. Coordinates are multiplied by
// `metersPerUnit`. Throws std::runtime_error that names the file and the fault: missing, empty, not
// a mesh, no triangles, NaN or infinite vertices, or cut short.
Mesh loadMesh(const std::filesystem::path& file, double metersPerUnit = 1.0);

// The same, part by part: the objects or groups of the file in their order, those of equal names
// merged. A part without a name is called "part 1" and so on. Throws as loadMesh() does.
std::vector<NamedMesh> loadMeshParts(const std::filesystem::path& file, double metersPerUnit = 1.0);

}  // namespace cloudcontact
