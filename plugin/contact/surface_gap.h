// SurfaceGap: the nearest points of two clouds that do not touch, however far apart.
#pragma once

#include <cloudcontact/contact/contact.h>

#include <optional>

namespace cloudcontact {

struct SurfaceGap {
  Vec3 onA = Vec3::Zero(), onB = Vec3::Zero();  // world [m]
  double distance = 0;                          // [m]
};

// Two bodies with fields. Empty if they are `within` [m] of each other nowhere. By the triangles of
// both surfaces, which cut edges by up to 0.3 voxel and corners by 0.6; on faces within 0.05.
std::optional<SurfaceGap> surfaceGap(const ContactBody& a, const ContactBody& b, double within);

}  // namespace cloudcontact
