// A replay's bodies and their motion as binary glTF 2.0 (.glb), for Blender and any other viewer.
#pragma once

#include <string>

#include "replay/replay.h"

namespace cloudcontact::program {

// Each body is a node named after it, its meshes below it; equal meshes are stored once. Nodes move
// by one animation of linear keys. The root turns this program's z, up, into glTF's y. Bodies of
// a replay of several takes stand below a node named after the take. Endless planes are squares
// about the take.
std::string gltfBytes(const Replay& replay);

}  // namespace cloudcontact::program
