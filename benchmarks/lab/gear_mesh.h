// Spur gears as closed meshes, by the involute's formula.
#pragma once

#include <cloudcontact/mesh/mesh.h>

namespace cloudcontact::program::lab {

// Two gears of one module and pressure angle mesh at a distance of (teeth + teeth) module / 2.
struct Gear {
  int teeth = 18;                             // at least 17: fewer would need an undercut
  double module = 4e-3;                       // [m] pitch diameter per tooth
  double pressureAngle = 0.3490658503988659;  // [rad], 20 deg
  double width = 10e-3;                       // [m] along z
  double thinned = 0;                         // [m] taken off a tooth, along the pitch circle
  int flankSteps = 8;                         // along each flank

  double pitchRadius() const { return teeth * module / 2; }
};

// About z, -width/2 <= z <= width/2, a tooth's middle on the x axis.
Mesh gearMesh(const Gear& gear);

}  // namespace cloudcontact::program::lab
