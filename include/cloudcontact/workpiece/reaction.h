// The reaction force on a tool: its magnitude from a law, its direction from the digital normal.
// Paper, Steps 4 and 5; equations (3) and (6).
#pragma once

#include <cloudcontact/base/wrench.h>
#include <cloudcontact/workpiece/collision_finder.h>

namespace cloudcontact {

// FR = k d + c v (3) [N], with k and c of the collision (1), (2); at least 0, so that it never
// pulls. `rate`: v, the rate of the depth, positive where it grows [m/s].
double kelvinVoigt(const Collision& collision, double depth, double rate);

// What is made of the digital normal.
enum class Direction : std::uint8_t {
  Unit,     // FR F / |F| (6)
  Unscaled  // FR F: "the absolute value may be omitted". F counts in voxels, so that the
            // resolution does not scale the force
};

struct Reaction {
  Wrench onTool;         // world; torque about the tool's position
  double magnitude = 0;  // FR [N]
  // Each tissue's part of `onTool.force`, in the order of BaseVectorField::tissues(). They add up
  // to the whole.
  std::vector<Vec3> tissues;
};

// Writes to `reaction`, whose memory is reused. The tissues share the force by N k d + N c v. For a
// magnitude from a law other than (3), pass depth 1 and rate 0: they then share it by N k.
void react(const Collision& collision, const BaseVectorField& workpiece, double magnitude,
           double depth, double rate, const Vec3& toolPlace, Direction direction,
           Reaction& reaction);

}  // namespace cloudcontact
