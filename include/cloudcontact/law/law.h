// The Kelvin-Voigt law, FR = k d + c v (paper (3)), in the two forms this project offers, and how
// two bodies' materials become one pair's.
#pragma once

#include <optional>

namespace cloudcontact {

enum class LawForm {
  Paper,       // one spring per pair, shared out among the contacts: k [N/m], c [N s/m]
  Foundation,  // stiffness per area: k [N/m^3], c [N s/m^3]; exactly conservative
  Rigid        // no law: Bullet's bare contact rows
};

// One body's stiffness and damping; units as its LawForm says.
struct Material {
  double stiffness = 0;
  double damping = 0;
};

// Two materials in series: k = kA kB / (kA + kB), c = (cA kB^2 + cB kA^2) / (kA + kB)^2. A body
// that states none is rigid; where neither states one the result is empty, and the pair's spring is
// found for it (automatic_spring.h).
std::optional<Material> inSeries(const std::optional<Material>& a,
                                 const std::optional<Material>& b);

// As hard as a step of `step` seconds allows a pair of effective mass `mass` [kg], at damping
// ratio 1: the limit of the automatic spring. DESIGN.md, "The method", 8.
Material stepLimited(double mass, double step);

}  // namespace cloudcontact
