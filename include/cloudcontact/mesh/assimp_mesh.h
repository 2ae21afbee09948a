// Assimp's meshes as meshes to digitize, for programs that read their files themselves. Part of the
// target CloudContact::files.
#pragma once

#include <cloudcontact/mesh/mesh.h>

struct aiMesh;
struct aiScene;

namespace cloudcontact {

// The triangles of a mesh in its own coordinates, times `metersPerUnit`. Faces of other kinds are
// left out: load with aiProcess_Triangulate. Throws std::invalid_argument where metersPerUnit is
// not positive and finite, and as validate(Mesh) does.
Mesh meshOf(const aiMesh& mesh, double metersPerUnit = 1);

// The meshes of a scene with node transforms applied; those of equal names are one part. As above.
std::vector<NamedMesh> meshParts(const aiScene& scene, double metersPerUnit = 1);

}  // namespace cloudcontact
