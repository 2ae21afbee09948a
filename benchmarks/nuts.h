// M16 nuts and the settings of heaps made of them.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "heap.h"
#include "scene/bullet_methods.h"
#include "scene/generated_mesh.h"

namespace cloudcontact {

constexpr double kNutHeight = 13e-3, kNutWidth = 24e-3;  // of a M16 nut [m]

// Centered on the origin.
inline Mesh nut() {
  Mesh mesh = program::nutMesh(program::Thread{}, kNutHeight, kNutWidth);
  for (Vec3& v : mesh.vertices) v.z() -= kNutHeight / 2;
  return mesh;
}

// All settings but the shape.
inline HeapSettings nutHeap(int bodies, double voxel, int threads) {
  HeapSettings settings;
  settings.bodies = bodies;
  settings.across = kNutWidth / std::cos(0.5235987755982988);  // across corners
  settings.height = kNutHeight;
  settings.voxel = voxel;
  settings.threads = threads;
  return settings;
}

// Makes the bodies of convex parts with Bullet's own law. `keep` must outlive the heap.
inline void makeOfParts(HeapSettings& settings, const program::ConvexParts& parts,
                        std::vector<std::shared_ptr<void>>& keep) {
  settings.clouds = false;
  settings.shape = [&] {
    const program::BulletShape made = program::convexPartsShape(parts);
    keep.insert(keep.end(), made.keep.begin(), made.keep.end());
    return made.shape;
  };
}

}  // namespace cloudcontact
