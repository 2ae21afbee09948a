// The chart of a wrench over time: its force and its torque, along three axes.
#pragma once

#include <string>
#include <vector>

#include "draw/drawing.h"
#include "scene/scene.h"

namespace cloudcontact::program {

struct WrenchAt {
  double time = 0;                                   // [s]
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();  // [N, N m]
};

// Throws std::invalid_argument if there are none.
Drawing wrenchChart(const std::vector<WrenchAt>& wrenches, const std::string& title,
                    const std::string& below);

}  // namespace cloudcontact::program
