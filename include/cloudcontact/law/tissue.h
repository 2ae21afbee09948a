// What a body is made of, where it is made of several things: stiffness, damping, hardness and
// density of each (paper, Steps 3 to 5: enamel, dentin, pulp, caries).
#pragma once

#include <string>
#include <vector>

namespace cloudcontact {

struct Tissue {
  std::string name;
  double stiffness = 0;  // k [N/m] of a contact with this alone, paper (1)
  double damping = 0;    // c [N s/m], paper (2)
  double hardness =
      0;               // [Pa] resistance to cutting: h in paper (5') is this over the table's first
  double density = 0;  // [kg/m^3], weighs the matter in the centre of gravity Gc
};

// One entry a material. Names are those of a cloud's materials (Cloud::materials).
using TissueTable = std::vector<Tissue>;

// Throws std::invalid_argument, naming tissue and field, where a value is negative or not finite, a
// stiffness or density is not positive, or two tissues have one name.
void requireTissues(const TissueTable& table);

// The table's entries in the order of `names`. Throws std::invalid_argument, naming it, where one
// is not in the table. A body without names is all of the table's first.
TissueTable tissuesOf(const TissueTable& table, const std::vector<std::string>& names);

// Enamel, dentin, pulp, caries. Densities and hardnesses are measured ones; so are the ratios of
// the stiffnesses, which follow the moduli of elasticity. Their scale is the caller's, for no
// haptic device renders what a tooth has: `enamel` is the stiffness of enamel [N/m]. Sources stand
// at the figures in tissue.cpp.
TissueTable dentalTissues(double enamel = 2e4);

}  // namespace cloudcontact
