// A replay's bodies and their motion as binary glTF 2.0 (.glb), for Blender and any other viewer.
#pragma once

#include <string>

#include "replay/replay.h"

namespace cloudcontact::program {

// Each body is a node of its name with its meshes as children; equal meshes are stored once. One
// animation with linear keys moves the nodes. The surface of a body that is cut consists of nodes
// that are shown for a time, by steps of their scale between 0 and 1. The root node turns z up into
// glTF's y up. With several takes, each has a node of its name above its bodies. Infinite planes
// become squares around the take.
std::string gltfBytes(const Replay& replay);

}  // namespace cloudcontact::program
