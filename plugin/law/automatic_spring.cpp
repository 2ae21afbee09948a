// The spring for pairs without a stated stiffness.
//
// The stiffest spring that the step allows (stepLimited) is too stiff: at 1 kHz a body's weight
// sinks it by 0.0001 voxel, and bodies grind on the noise of the voxel fits, which is a hundred
// times that. So the force has two parts (docs/tried.md has the figures):
//
//   Up to `even`, 0.2 voxel, the stiffness is weight / (0.1 voxel). The weight sags by 0.1 voxel,
//   and a few times the weight, spread over several places, is still on a straight line.
//   Beyond `even`, f = soft x / (1 - x / reach) in addition, where x is the depth beyond and
//   `reach` is 0.1 voxel, until the slope is what the step allows. Twenty times the weight sag by
//   0.3 voxel, and the joints of a tall stack stiffen with their load, which keeps it from
//   buckling.
//
// What the step allows is stepLimited() for Bullet's own solver, whose ten sweeps do not carry
// more. A solver that goes on until its rows agree (NewtonSolver) carries `bears` times as
// much, and needs it at long steps: at 60 Hz the limit of a brick's own mass is softer than its
// weight's sag asks for, so that towers sink by a third of a voxel a joint, and buckle at 120 Hz.
//
// With such a solver the damping ratio is 1 for the mass that the spring bears, by its force or by
// its stiffness: for the pair's own mass alone a ton on a kilogram topples.
//
// Bullet's row is a straight line over the step. Where bodies part it is the tangent: f is convex,
// so the line lies below it, and less energy is returned than was stored. Where bodies close it is
// the chord to the depth without contact: it lies above f all the way, so more energy is taken than
// is stored. With tangents only, a fast body would enter almost without resistance.
#include <cloudcontact/law/automatic_spring.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace cloudcontact {

namespace {

constexpr double kSagVoxels = 0.1, kEvenVoxels = 0.2, kReachVoxels = 0.1;
// [m/s^2] Gravity for bodies without a weight: machines in a void are built as on the ground.
constexpr double kGravity = 9.81;

// The depth beyond `even` from which the stiffness is `hard`.
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
  // Damped for what it bears: the mass for which it would be at the step's limit and, with a solver
  // that carries more than that limit, the mass of which its force is the weight.
  const double push = next > from ? std::max(now, force(next)) : now;
  const double loads = hard > limit ? push / weight : 1;
  const double borne = mass * std::max({1.0, slope / limit, loads});
  // Not negative, even by rounding: a row near depth 0 is then no stiffer than the line.
  return {slope, 2 * std::sqrt(slope * borne), std::max(0.0, from - now / slope)};
}

KelvinVoigt SpringTangent::row(double depth, double step) const {
  // For a gap Bullet's row applies k and c to the depth at the step's end.
  if (!(depth > 0)) return {slope, damping};
  const double secant = std::max(0.0, slope * (1 - offset / depth));
  return {secant, damping + step * (slope - secant)};
}

AutomaticSpring automaticSpring(double mass, double weight, double voxel, double step, double joint,
                                double bears) {
  if (!(voxel > 0)) throw std::invalid_argument("automaticSpring: the voxel must be positive");
  if (!(joint > 0) || joint > 1)
    throw std::invalid_argument("automaticSpring: joint must be above 0 and at most 1");
  if (!(bears >= 1) || !std::isfinite(bears))
    throw std::invalid_argument("automaticSpring: bears must be finite and at least 1");
  const double limit = stepLimited(mass, step).stiffness, hard = bears * limit,
               unit = joint * voxel;
  if (!(weight > 0)) weight = mass * kGravity;
  return {mass,
          std::min(hard, weight / (kSagVoxels * unit)),
          hard,
          kEvenVoxels * unit,
          kReachVoxels * unit,
          limit,
          weight};
}

}  // namespace cloudcontact
