// Where the tip of a cloud ends. Its depth field rounds edges and corners by up to half a voxel and
// more where it is thinner than that; the volumes of its voxels are exact.
#pragma once

#include <cloudcontact/law/solid.h>

namespace cloudcontact {

// A place near a cloud's tip, in the frame of the area's owner.
struct TipPlace {
  Vec3 at = Vec3::Zero();    // on the axis of the tip [m]
  Vec3 down = Vec3::Zero();  // unit: the way to the tip's end
  double radius = 0;         // around the axis: what lies farther aside is not of this tip [m]
};

// How far below `place.at` the matter of the cloud ends [m], if it ends near `guess`, the end by
// its depth field. By the volume below a level and its first two moments, as the cross section of a
// tip is a power of the way from its end. `area` must hold a CloudSolid.
double cloudTip(const PlacedSolid& area, const TipPlace& place, double guess);

}  // namespace cloudcontact
