// Makes bodies for the scenes of tests.
#pragma once

#include "scene/scene.h"

namespace cloudcontact::program {

inline constexpr double kGravity = 9.8;  // [m/s^2]
inline constexpr double kStep = 1.0 / 240;

inline SceneBody bodyWith(const std::string& name, const SceneGeometry& geometry,
                          const Vec3& position, double mass) {
  SceneBody body;
  body.name = name;
  body.pose.position = position;
  body.isStatic = mass == 0;
  if (mass > 0) body.mass = mass;
  body.collisions.push_back({"c", Pose(), geometry});
  return body;
}

}  // namespace cloudcontact::program
