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
// What bears many times its own mass is pressed in by voxels all the same: a ton on a kilogram
// stands 0.7 voxel deep in it at 240 Hz, the topmost of thirty links 0.7 in the next. Where the
// solver can bear harder rows (ExtrapolatingSolver) `bears` says for how many times the pair's own
// mass: from `deep`, 0.3 voxel, on, f = hard x / (1 - x / last) in addition, `last` 0.1 voxel,
// until its slope is what the step allows for that mass. The damping is then that mass's, too: with
// the light body's own the ton bounced by a metre. Ten is what ten sweeps carry: with 30 a wrecking
// ball gains energy at 60 Hz. What stands less deep is not changed.
//
// Bullet's row is a straight line over the step. Where bodies part it is the tangent: f is convex,
// so the line lies below it, and less is given back than was stored. Where they close it is the
// chord to where they would be without contact: above f all the way, so that more is taken than is
// stored. With tangents alone nothing was gained either, but a fast body came in almost for nothing
// and left with 0.46 of its speed; damping ratio 1 means exp(-2) = 0.135 at most.
#include <cloudcontact/law/automatic_spring.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace cloudcontact {

namespace {

constexpr double kSagVoxels = 0.1, kEvenVoxels = 0.2, kReachVoxels = 0.1;
constexpr double kDeepVoxels = 0.3, kLastVoxels = 0.1;
// What bodies weigh that do not say: nothing pulls gears in a void, but things are built to bear
// what they would on the ground.
constexpr double kOnTheGround = 9.81;

// How far beyond `even` the spring is as hard as it may be.
double hardFrom(const AutomaticSpring& s) {
  return s.reach * (1 - std::sqrt(s.soft / s.hard));
}

// The same beyond `deep`.
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
  // Harder than its own mass's limit it is for the mass that it bears.
  const double borne = mass * std::max(1.0, slope / hard);
  return {slope, 2 * std::sqrt(slope * borne), from - now / slope};
}

KelvinVoigt SpringTangent::row(double depth, double step) const {
  // Of a gap Bullet's row takes k and c for what will be inside at the step's end.
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
  if (!(weight > 0)) weight = mass * kOnTheGround;
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
