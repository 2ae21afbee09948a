// The spring that a pair gets where nobody states one.
//
// As hard as the step allows (stepLimited) it would be, at 1 kHz, so hard that a body's weight
// sinks it by 0.0001 voxel, and bodies grind on the noise of the fits, a hundred times that: balls
// lost 14 % and cylinders 44 % of their speed in 3 s, slopes crept, a screw locked at half of
// theory, a spike in a hole jumped out. So:
//
//   up to `even`, 0.2 voxel, its stiffness is weight / (0.1 voxel): that sags by 0.1 voxel, and
//   what bears a few times that in several places still meets a straight line. With 0.05 a spike
//   that slides on its flank is 0.9 voxel off its way, and a wedge in a crack rocks; with `even` at
//   0.15 the wedge rocks, too. The price: a box over a table's edge leans out before it tips.
//   Beyond, f = soft x / (1 - x / reach) in addition, x the way beyond and `reach` 0.1 voxel, until
//   its slope is that of stepLimited: twenty times the weight sag by 0.3 voxel, not 2, and the
//   joints of a stack of twenty stiffen as their load grows, which keeps it from buckling.
//
// Bullet's row is a straight line over the step. Where bodies part it is the tangent: f is convex,
// so the line lies below it, and less is given back than was stored. Where they close it is the
// chord to where they would be without contact: above f all the way, so that more is taken than is
// stored. With tangents alone nothing was gained either, but a fast body came in almost for nothing
// and left with 0.46 of its speed; damping ratio 1 means exp(-2) = 0.135 at most.
#include <cloudcontact/automatic_spring.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace cloudcontact {

namespace {

constexpr double kSagVoxels = 0.1, kEvenVoxels = 0.2, kReachVoxels = 0.1;
// What bodies weigh that do not say: nothing pulls gears in a void, but things are built to bear
// what they would on the ground.
constexpr double kOnTheGround = 9.81;

// How far beyond `even` the spring is as hard as it may be.
double hardFrom(const AutomaticSpring& s) {
  return s.reach * (1 - std::sqrt(s.soft / s.hard));
}

}  // namespace

double AutomaticSpring::force(double depth) const {
  if (!(depth > 0)) return 0;
  const double beyond = std::max(0.0, depth - even), x = std::min(beyond, hardFrom(*this));
  return soft * std::min(depth, even) + soft * x / (1 - x / reach) + hard * (beyond - x);
}

double AutomaticSpring::stiffness(double depth) const {
  if (depth - even >= hardFrom(*this)) return hard;
  const double left = 1 - std::max(0.0, depth - even) / reach;
  return soft / (left * left);
}

double AutomaticSpring::sag(double load) const {
  const double more = load - soft * even, most = hardFrom(*this), held = force(even + most);
  if (more <= 0) return load / soft;
  return even + (load < held ? reach * more / (soft * reach + more) : most + (load - held) / hard);
}

SpringTangent AutomaticSpring::tangent(double depth, double closing, double step) const {
  const double from = std::max(0.0, depth), next = depth + step * closing, now = force(depth);
  double slope = stiffness(from);
  if (next > from) slope = std::max(slope, (force(next) - now) / (next - from));
  return {slope, 2 * std::sqrt(slope * mass), from - now / slope};
}

Material SpringTangent::row(double depth, double step) const {
  // Of a gap Bullet's row takes k and c for what will be inside at the step's end.
  if (!(depth > 0)) return {slope, damping};
  const double secant = std::max(0.0, slope * (1 - offset / depth));
  return {secant, damping + step * (slope - secant)};
}

AutomaticSpring automaticSpring(double mass, double weight, double voxel, double step) {
  if (!(voxel > 0)) throw std::invalid_argument("automaticSpring: the voxel must be positive");
  const double hard = stepLimited(mass, step).stiffness;
  if (!(weight > 0)) weight = mass * kOnTheGround;
  return {mass, std::min(hard, weight / (kSagVoxels * voxel)), hard, kEvenVoxels * voxel,
          kReachVoxels * voxel};
}

}  // namespace cloudcontact
