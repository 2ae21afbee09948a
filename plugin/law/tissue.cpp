// Tissue tables, and the dental one with its sources.
#include <cloudcontact/law/tissue.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

namespace cloudcontact {

namespace {

void validate(const Tissue& tissue, const char* field, double value, bool positive) {
  if (std::isfinite(value) && (positive ? value > 0 : value >= 0)) return;
  throw std::invalid_argument("tissue " + tissue.name + ": its " + field + " must be " +
                              (positive ? "positive" : "zero or more") + " and finite");
}

}  // namespace

void validate(const TissueTable& table) {
  if (table.empty()) throw std::invalid_argument("the table of tissues is empty");
  std::set<std::string> names;
  for (const Tissue& t : table) {
    if (!names.insert(t.name).second)
      throw std::invalid_argument("tissue " + t.name + ": is in the table twice");
    validate(t, "stiffness", t.stiffness, true);
    validate(t, "damping", t.damping, false);
    validate(t, "hardness", t.hardness, false);
    validate(t, "density", t.density, true);
    validate(t, "elasticity", t.elasticity, false);
  }
}

TissueTable tissuesOf(const TissueTable& table, const std::vector<std::string>& names) {
  validate(table);
  if (names.empty()) return {table.front()};
  TissueTable found;
  for (const std::string& name : names) {
    const auto at =
        std::find_if(table.begin(), table.end(), [&](const Tissue& t) { return t.name == name; });
    if (at == table.end())
      throw std::invalid_argument("material " + name + ": not in the table of tissues");
    found.push_back(*at);
  }
  return found;
}

// Hardness: enamel HV 274.8, dentin HV 65.6 (Chun, Choi, Lee, J. Dent. Biomech. 5, 2014); a carious
// lesion of ICDAS code 3 KHN 31.7, and its mineral 35.5 % of the volume (Shimizu et al., Dent.
// Mater. J. 34, 2015), which gives its density, with 3160 kg/m^3 for the mineral and water for the
// rest. Moduli: enamel 84 GPa (He and others by indentation: 80-105), dentin 20 GPa (Kinney et al.,
// Crit. Rev. Oral Biol. Med. 14, 2003: 20-25), pulp 2 MPa as in finite-element studies, caries in
// proportion to its hardness and dentin's. Densities: enamel 2970, dentin 2140 kg/m^3 (Manly et
// al., J. Biol. Chem. 128, 1939). No hardness of pulp is known; its modulus stands in. The damping
// is this project's choice: stiffness times 20 microseconds.
TissueTable dentalTissues(double enamel) {
  if (!(enamel > 0) || !std::isfinite(enamel))
    throw std::invalid_argument("the stiffness of enamel must be positive and finite");
  constexpr double kVickers = 9.80665e6;  // [Pa] of one unit, Knoop's too
  constexpr double kEnamel = 84e9, kDentin = 20e9, kPulp = 2e6;
  constexpr double kDentinHardness = 65.6 * kVickers, kCariesHardness = 31.7 * kVickers;
  const auto tissue = [&](const char* name, double modulus, double hardness, double density) {
    const double k = enamel * modulus / kEnamel;
    return Tissue{name, k, 2e-5 * k, hardness, density, modulus};
  };
  return {tissue("enamel", kEnamel, 274.8 * kVickers, 2970),
          tissue("dentin", kDentin, kDentinHardness, 2140), tissue("pulp", kPulp, kPulp, 1000),
          tissue("caries", kDentin * kCariesHardness / kDentinHardness, kCariesHardness,
                 0.355 * 3160 + 0.645 * 1000)};
}

}  // namespace cloudcontact
