// Magnitude and direction of the reaction, and each tissue's part.
#include <cloudcontact/workpiece/reaction.h>

#include <algorithm>

namespace cloudcontact {

double kelvinVoigt(const Collision& collision, double depth, double rate) {
  if (collision.empty() || !(depth > 0)) return 0;
  return std::max(0.0, collision.stiffness * depth + collision.damping * rate);
}

void react(const Collision& collision, const BaseVectorField& workpiece, double magnitude,
           double depth, double rate, const Vec3& toolPlace, Direction direction,
           Reaction& reaction) {
  const TissueTable& tissues = workpiece.tissues();
  reaction.tissues.assign(tissues.size(), Vec3::Zero());
  reaction.onTool = {};
  reaction.magnitude = magnitude;
  if (collision.empty()) return;
  const Vec3 along = direction == Direction::Unit ? collision.normal()
                                                  : Vec3(collision.mean / workpiece.voxelSize());
  reaction.onTool.force = magnitude * along;
  reaction.onTool.torque = (collision.center - toolPlace).cross(reaction.onTool.force);
  const auto weight = [&](std::size_t t) {
    return collision.tissueCount[t] *
           std::max(0.0, tissues[t].stiffness * depth + tissues[t].damping * rate);
  };
  double all = 0;
  for (std::size_t t = 0; t < tissues.size(); ++t) all += weight(t);
  if (!(all > 0)) return;
  for (std::size_t t = 0; t < tissues.size(); ++t)
    reaction.tissues[t] = weight(t) / all * reaction.onTool.force;
}

}  // namespace cloudcontact
