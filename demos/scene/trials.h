// What is tuned (tuning.h): a pair of bodies, or a scene.
#pragma once

#include <functional>

#include "scene/body.h"
#include "scene/scene.h"
#include "scene/tuning.h"

namespace cloudcontact::program {

struct Trials {
  TuneLimits limits;
  std::function<Trial(const TuneSetting&)> attempt;
};

// A at the origin and B at `pose`, and where B is half of --tolerance beside it. `law`: the pair's.
// Throws BadInput as digitizeBody() does.
Trials pairTrials(const Body& a, const Body& b, const Pose& pose, const Law& law,
                  const CommonOptions& options);

// All pairs of clouds at several instants of the scene's first `seconds`, run with default voxels.
// Throws BadInput as World does.
Trials sceneTrials(const SceneDescription& scene, double seconds, const CommonOptions& options);

}  // namespace cloudcontact::program
