// Joints of SDFormat and URDF files: their axes, limits, springs and friction.
#pragma once

#include <functional>
#include <sdf/Joint.hh>
#include <string>

#include "scene/scene.h"
#include "scene/sdf_values.h"

namespace cloudcontact::program {

// A joint of the model `scope`. `bodyOf`: the number of the body with a link, or -1 for the world;
// of an element that names it. Throws BadInput.
SceneJoint readJoint(
    const SdfValues& in, const sdf::Joint& joint, const std::string& scope, const Pose& modelPose,
    const std::function<int(const std::string& link, const std::string& element)>& bodyOf);

}  // namespace cloudcontact::program
