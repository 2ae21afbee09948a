// The spring for pairs without a stated stiffness.
//
// The stiffest spring that the step allows (stepLimited) is too stiff: at 1 kHz a body's weight
// sinks it by 0.0001 voxel, and bodies grind on the noise of the voxel fits, which is a hundred
// times that. So the force has three parts (docs/measurements.md has the figures):
//
//   Up to `even`, 0.2 voxel, the stiffness is weight / (0.1 voxel). The weight sags by 0.1 voxel,
//   and a few times the weight, spread over several places, is still on a straight line. Beyond
//   `even`, f = soft x / (1 - x / reach) in addition, where x is the depth beyond and `reach` is
//   0.1 voxel, until the slope is that of stepLimited. Twenty times the weight sag by 0.3 voxel,
//   and the joints of a tall stack stiffen with their load, which keeps it from buckling.
//   Beyond `deep`, 0.3 voxel, f = hard x / (1 - x / last) in addition, `last` 0.1 voxel, until the
//   slope is what the step allows for `bears` times the pair's mass. This is for light bodies that
//   bear heavy ones, if the solver can bear harder rows (ExtrapolatingSolver). The damping is then
//   that mass's, too. Ten is what ten sweeps
//   carry, a hundred what ExtrapolatingSolver does, which goes on until its rows agree.
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
constexpr double kDeepVoxels = 0.3, kLastVoxels = 0.1;
// [m/s^2] Gravity for bodies without a weight: machines in a void are built as on the ground.
constexpr double kGravity = 9.81;

// The depth beyond `even` from which the stiffness is `hard`.
double hardFrom(const AutomaticSpring& s) {
  return s.reach * (1 - std::sqrt(s.soft / s.hard));
}

// The depth beyond `deep` from which the stiffness is `hardest`.
double hardestFrom(const AutomaticSpring& s) {
  return s.last * (1 - std::sqrt(s.hard / s.hardest));
}

}  // namespace

double AutomaticSpring::force(double depth) const {
  if (!(depth > 0)) return 0;
  const double shallow = std::min(depth, deep), beyond = std::max(0.0, shallow - even),
               x = std::min(beyond, hardFrom(*this));
  const double up =
      soft * std::min(shallow, even) + soft * x / (1 - x / reach) + hard * (beyond - x);
  const double more = depth - shallow, y = std::min(more, hardestFrom(*this));
  return up + hard * y / (1 - y / last) + hardest * (more - y);
}

double AutomaticSpring::stiffness(double depth) const {
  if (depth > deep) {
    const double left = 1 - std::min(depth - deep, hardestFrom(*this)) / last;
    return hard / (left * left);
  }
  if (depth - even >= hardFrom(*this)) return hard;
  const double left = 1 - std::max(0.0, depth - even) / reach;
  return soft / (left * left);
}

double AutomaticSpring::sag(double load) const {
  const double bears = load - force(deep);
  if (bears > 0) {
    const double farthest = hardestFrom(*this), carried = hard * farthest / (1 - farthest / last);
    return deep + (bears < carried ? last * bears / (hard * last + bears)
                                   : farthest + (bears - carried) / hardest);
  }
  const double more = load - soft * even, most = hardFrom(*this), held = force(even + most);
  if (more <= 0) return load / soft;
  return even + (load < held ? reach * more / (soft * reach + more) : most + (load - held) / hard);
}

SpringTangent AutomaticSpring::tangent(double depth, double closing, double step) const {
  const double from = std::max(0.0, depth), next = depth + step * closing, now = force(depth);
  double slope = stiffness(from);
  if (next > from) slope = std::max(slope, (force(next) - now) / (next - from));
  // Beyond its own mass's limit it is hard for the mass that it bears.
  const double borne = mass * std::max(1.0, slope / hard);
  return {slope, 2 * std::sqrt(slope * borne), from - now / slope};
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
  const double hard = stepLimited(mass, step).stiffness, unit = joint * voxel;
  if (!(weight > 0)) weight = mass * kGravity;
  return {mass,
          std::min(hard, weight / (kSagVoxels * unit)),
          hard,
          kEvenVoxels * unit,
          kReachVoxels * unit,
          kDeepVoxels * voxel,
          kLastVoxels * voxel,
          bears * hard};
}

}  // namespace cloudcontact
