// Kelvin-Voigt materials: two bodies' in series, and the stiffest a step can hold.
#include <cloudcontact/law.h>

#include <cmath>
#include <stdexcept>

namespace cloudcontact {

namespace {

// k h^2 / m where nobody states a stiffness. At damping ratio 1 the backward Euler rows that Bullet
// solves leave 1 / (1 + sqrt(kHardness)) of a penetration after each step, so 1 halves it: the
// larger, the harder a pair stands (its sag under its own weight is g h^2 / kHardness) but the
// slower the solver's sweeps converge in a stack, and the more the surface's own grid is felt. The
// row is stable at any value; this one is about what the sweeps can still follow.
constexpr double kHardness = 1.0;

}  // namespace

std::optional<Material> inSeries(const std::optional<Material>& a,
                                 const std::optional<Material>& b) {
  if (!a || !b) return a ? a : b;
  const double sum = a->stiffness + b->stiffness;
  if (!(sum > 0)) return Material{0, 0};  // two bodies that do not resist at all
  const double ka = a->stiffness / sum, kb = b->stiffness / sum;
  return Material{a->stiffness * kb, a->damping * kb * kb + b->damping * ka * ka};
}

Material stepLimited(double mass, double step) {
  if (!(mass > 0) || !(step > 0) || !std::isfinite(mass) || !std::isfinite(step))
    throw std::invalid_argument("stepLimited: mass and step must be positive and finite");
  const double stiffness = kHardness * mass / (step * step);
  return {stiffness, 2 * std::sqrt(stiffness * mass)};
}

}  // namespace cloudcontact
