// Makes bodies and settings for the scenes of tests.
#pragma once

#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/voxels/voxel_cut.h>

#include <utility>
#include <vector>

#include "scene/scene.h"
#include "scene/world.h"

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

// Bodies that are models of their own, with friction 0.5.
inline SceneDescription sceneOf(std::vector<SceneBody> bodies) {
  SceneDescription scene;
  scene.bodies = std::move(bodies);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    scene.bodies[i].model = int(i);
    scene.bodies[i].friction = 0.5;
  }
  return scene;
}

// A world on one thread, with voxels of this size [m].
inline WorldSettings voxels(double voxel) {
  WorldSettings settings;
  settings.common.threads = 1;
  settings.voxel = voxel;
  return settings;
}

// The cuts that leave nothing of the voxels with low <= x < high [m, in the cloud's frame].
inline std::vector<VoxelCut> slice(const Cloud& cloud, double low, double high) {
  std::vector<VoxelCut> cuts;
  const Eigen::Vector3i n = cloud.size();
  for (int x = 0; x < n.x(); ++x) {
    const double at = cloud.center(x, 0, 0).x();
    if (at < low || at >= high) continue;
    for (int y = 0; y < n.y(); ++y)
      for (int z = 0; z < n.z(); ++z)
        if (cloud.coverage(x, y, z) > 0) cuts.push_back({{x, y, z}, 0});
  }
  return cuts;
}

}  // namespace cloudcontact::program
