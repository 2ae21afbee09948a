// A world for tests of soft tissue, and bars of one or two tissues.
#pragma once

// First: Bullet's soft bodies declare a global named seed.
#include "bullet/bullet_world.h"

#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <cloudcontact/bullet/soft_tissue.h>

namespace cloudcontact::testing {

struct TissueWorld {
  explicit TissueWorld(double gravity, const CloudContactSettings& settings = {})
      : clouds(settings) {
    clouds.attach(dispatcher);
    recommendedSettings(world);
    world.setGravity({0, 0, btScalar(-gravity)});
    world.getWorldInfo().m_gravity.setValue(0, 0, btScalar(-gravity));
  }
  void step(double seconds, int count = 1) {
    for (int i = 0; i < count; ++i) world.stepSimulation(btScalar(seconds), 0);
  }

  CloudContact clouds;
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
};

// A box from the origin on.
inline Cloud boxCloud(const Vec3& size, double voxel) {
  DigitizeSettings settings;
  settings.voxelSize = voxel;
  settings.threads = 1;
  return digitize(boxMesh(size), settings).translated(0.5 * size);
}

// The same as two materials, the second above `height`.
inline Cloud layeredCloud(const Vec3& size, double voxel, double height) {
  const Cloud whole = boxCloud(size, voxel);
  auto voxels = std::make_shared<Cloud::Voxels>(whole.voxels());
  voxels->materials = {"lower", "upper"};
  for (std::size_t brick = 0; brick < voxels->table.size(); ++brick) {
    const int nx = voxels->bricks.x(), ny = voxels->bricks.y(), n = static_cast<int>(brick);
    const Eigen::Vector3i first = kBrickEdge * Eigen::Vector3i(n % nx, n / nx % ny, n / nx / ny);
    BrickMaterial of;
    for (int i = 0; i < kBrickVoxels; ++i)
      of[static_cast<std::size_t>(i)] =
          whole.center(0, 0, first.z() + i / (kBrickEdge * kBrickEdge)).z() > height;
    voxels->materialTable.push_back(static_cast<std::int32_t>(voxels->material.size()));
    voxels->material.push_back(of);
  }
  return {whole.voxelSize(), whole.origin(), voxels};
}

inline Tissue soft(const char* name, double elasticity, double density = 1000,
                   double hardness = 1e5) {
  return {name, 1000, 10, hardness, density, elasticity};
}

inline Vec3 placeOf(const SoftTissue& tissue, int node) {
  const btVector3& x = tissue.body().m_nodes[node].m_x;
  return {x.x(), x.y(), x.z()};
}
inline Vec3 velocityOf(const SoftTissue& tissue, int node) {
  const btVector3& v = tissue.body().m_nodes[node].m_v;
  return {v.x(), v.y(), v.z()};
}

}  // namespace cloudcontact::testing
