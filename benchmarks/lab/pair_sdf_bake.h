// A distance function as btSdfCollisionShape takes it: baked on a grid of cubic cells.
#pragma once

#include <cloudcontact/base/pose.h>

#include <functional>

#include "scene/bullet_methods.h"

namespace cloudcontact::program::lab {

// `distance` [m], negative inside, sampled over `domain` in cells of about `cell` [m], at most
// kMaxSdfCells along an axis. Outside the domain Bullet sees nothing. Throws std::runtime_error
// where Bullet does not take the data.
constexpr int kMaxSdfCells = 64;
BulletShape bakedSdfShape(const std::function<double(const Vec3&)>& distance,
                        const Eigen::AlignedBox3d& domain, double cell);

}  // namespace cloudcontact::program::lab
