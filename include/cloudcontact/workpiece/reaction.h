// The force on a tool: magnitude by a law, direction by the digital normal. Paper, Steps 4 and 5;
// equations (3) and (6).
#pragma once

#include <cloudcontact/base/wrench.h>
#include <cloudcontact/workpiece/collision_finder.h>

namespace cloudcontact {

// FR = k d + c v (3) [N], with the k and c that the collision voxels' tissues give (1), (2). Never
// pulls. `rate`: of the depth [m/s], positive where it grows.
double kelvinVoigt(const Collision& collision, double depth, double rate);

enum class Direction : std::uint8_t {
  Unit,     // FR F / |F| (6)
  Unscaled  // FR F: "the absolute value may be omitted"; F in voxels, so that its size, not the
            // resolution's, is what the window and its representative point make of it
};

struct Reaction {
  Wrench onTool;         // world; torque about the tool's place
  double magnitude = 0;  // FR [N], before the direction
  // Each tissue's part of `onTool.force`, in the order of the field's tissues: by its share of the
  // voxels and its own k and c. They add up to the whole.
  std::vector<Vec3> tissues;
};

// `reaction` keeps its memory. Its magnitude is shared out by N k d + N c v of each tissue, or,
// where a law other than (3) made it, by N k alone: give `rate` 0 and `depth` 1 then.
void react(const Collision& collision, const BaseVectorField& workpiece, double magnitude,
           double depth, double rate, const Vec3& toolPlace, Direction direction,
           Reaction& reaction);

}  // namespace cloudcontact
