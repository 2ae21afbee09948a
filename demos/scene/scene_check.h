// Whether the values of a scene or the settings of a world can be run, however they were made.
#pragma once

#include "scene/scene.h"

namespace cloudcontact::program {

struct WorldSettings;

// These throw BadInput that names the body or joint, the value, and what it may be.
void validate(const SceneBody& body);
void validate(const SceneJoint& joint);
void validate(const SceneDescription& scene);
// Numbers alone: what excludes each other is checkOptions()' (world_setup.h).
void validate(const WorldSettings& settings);

}  // namespace cloudcontact::program
