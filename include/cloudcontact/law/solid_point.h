// A point's place in a body.
#pragma once

#include <cloudcontact/base/pose.h>

namespace cloudcontact {

// At a point: signed depth, positive inside [m], and the outward unit normal of the nearest
// surface.
struct SolidPoint {
  double depth;
  Vec3 normal;
};

}  // namespace cloudcontact
