// The spring for pairs without a stated stiffness.
//
// The stiffest spring that the step allows (stepLimited) is too stiff: at 1 kHz a body's weight
// sinks it by 0.0001 voxel, and bodies grind on the noise of the voxel fits, which is a hundred
// times that. So the force has two parts (docs/measurements.md has the figures):
//
//   Up to `even`, 0.1 voxel, the stiffness is weight / (0.1 voxel), so the weight sags by that.
//   Beyond `even` it grows as exp(x / reach), x the depth beyond and `reach` 0.04 voxel, until it
//   is `hard`: in proportion to the load, so that the joints of a tall stack stiffen with it, which
//   keeps it from buckling. Twenty times the weight sag by 0.26 voxel.
//
// A pole instead of the exponential, x / (1 - x / reach), stiffens with the square of the load:
// towers of 12 then chatter at 240 Hz, where one side of a brick lifts by more than its sag within
// a step, and fall.
//
// `hard` is what the step allows, times `bears`. Ten sweeps of Bullet's own solver carry 1; one
// that goes on until its rows agree (ExtrapolatingSolver) carries hundreds. At 60 Hz, with 1, a
// tower of 12 sinks by 13 voxels; a cube of a millimeter by 4.
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

constexpr double kSagVoxels = 0.1, kEvenVoxels = 0.1, kReachVoxels = 0.04;
// [m/s^2] Gravity for bodies without a weight: machines in a void are built as on the ground.
constexpr double kGravity = 9.81;

// The depth beyond `even` from which the stiffness is `hard`.
double hardFrom(const AutomaticSpring& s) {
  return s.reach * std::log(s.hard / s.soft);
}

}  // namespace

double AutomaticSpring::force(double depth) const {
  if (!(depth > 0)) return 0;
  const double beyond = std::max(0.0, depth - even), x = std::min(beyond, hardFrom(*this));
  return soft * std::min(depth, even) + soft * reach * std::expm1(x / reach) + hard * (beyond - x);
}

double AutomaticSpring::stiffness(double depth) const {
  if (depth - even >= hardFrom(*this)) return hard;
  return soft * std::exp(std::max(0.0, depth - even) / reach);
}

double AutomaticSpring::sag(double load) const {
  const double more = load - soft * even, most = hardFrom(*this), held = force(even + most);
  if (more <= 0) return load / soft;
  return even +
         (load < held ? reach * std::log1p(more / (soft * reach)) : most + (load - held) / hard);
}

SpringTangent AutomaticSpring::tangent(double depth, double closing, double step) const {
  const double from = std::max(0.0, depth), next = depth + step * closing, now = force(depth);
  double slope = stiffness(from);
  if (next > from) slope = std::max(slope, (force(next) - now) / (next - from));
  return {slope, 2 * std::sqrt(slope * mass), from - now / slope};
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
  const double hard = bears * stepLimited(mass, step).stiffness, unit = joint * voxel;
  if (!(weight > 0)) weight = mass * kGravity;
  return {mass, std::min(hard, weight / (kSagVoxels * unit)), hard, kEvenVoxels * unit,
          kReachVoxels * unit};
}

}  // namespace cloudcontact
