// Bullet's meshes as meshes to digitize.
#pragma once

#include <cloudcontact/mesh/mesh.h>

class btStridingMeshInterface;

namespace cloudcontact {

// The triangles of all parts, with the interface's scaling. Whatever the type of its vertices and
// indices. Throws std::invalid_argument for a part without data, of an unknown type, or whose
// indices name no vertex, and as validate(Mesh) does.
Mesh meshOf(const btStridingMeshInterface& triangles);

}  // namespace cloudcontact
