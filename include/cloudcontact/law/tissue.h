// Tissue: stiffness, damping, hardness, density and elasticity of one material of a body (paper,
// steps 3 to 5: enamel, dentin, pulp, caries).
#pragma once

#include <string>
#include <vector>

namespace cloudcontact {

struct Tissue {
  std::string name;
  double stiffness = 0;  // k [N/m] of a contact with this tissue alone, paper (1)
  double damping = 0;    // c [N s/m], paper (2)
  double hardness = 0;   // [Pa] resistance to cutting; h in paper (5') is its ratio to the first's
  double density = 0;    // [kg/m^3] weight of voxels in the center of gravity Gc
  // [Pa] Young's modulus, for a body that deforms (SoftTissue); 0: not known. Such a body's
  // viscosity is this times damping / stiffness.
  double elasticity = 0;

  bool operator==(const Tissue& o) const {
    return name == o.name && stiffness == o.stiffness && damping == o.damping &&
           hardness == o.hardness && density == o.density && elasticity == o.elasticity;
  }
};

// One entry per material, by the names of a cloud's materials (Cloud::materials).
using TissueTable = std::vector<Tissue>;

// Throws std::invalid_argument, naming tissue and field, for an empty table, a value that is
// negative or not finite, a stiffness or density that is not positive, or a name that occurs twice.
void validate(const TissueTable& table);

// The table's entries in the order of `names`, or its first entry if there are no names. Throws
// std::invalid_argument for an invalid table and for a name that it does not have.
TissueTable tissuesOf(const TissueTable& table, const std::vector<std::string>& names);

// Enamel, dentin, pulp, caries. Densities, hardnesses and the ratios of the stiffnesses, which
// follow the moduli of elasticity, are measured (sources in tissue.cpp). No haptic device renders
// the stiffness of a tooth, so the caller sets the scale: `enamel` is the stiffness of enamel
// [N/m]. Throws std::invalid_argument if it is not positive and finite.
TissueTable dentalTissues(double enamel = 2e4);

}  // namespace cloudcontact
