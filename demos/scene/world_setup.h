// What a scene's world is made with, by the options of the command line: which bodies meet, the
// dispatcher, and the contacts of clouds.
#pragma once

#include <cloudcontact/bullet/cloud_contact.h>

#include <memory>
#include <vector>

#include "scene/scene_dispatcher.h"
#include "scene/world.h"

namespace cloudcontact::program {

// Throws BadInput if the options contradict each other or the method cannot do what they ask for.
void checkOptions(const WorldSettings& settings);

Surface surfaceOf(const SceneBody& body);
std::vector<ModelFilter::Body> modelsOf(const SceneDescription& scene);

// With a device if --backend asks for one and there is one.
SceneDispatcher makeDispatcher(btCollisionConfiguration* configuration,
                               const SceneDescription& scene, const CommonOptions& options);

std::unique_ptr<CloudContact> makeCloudContact(const CommonOptions& options);

}  // namespace cloudcontact::program
