// The tissues of a workpiece on the command line: a table by name or from a JSON file, and the
// tissue of each part.
#pragma once

#include <cloudcontact/law/tissue.h>

#include <string>
#include <utility>
#include <vector>

namespace cloudcontact::program {

// "dental" (with `stiffness` for enamel, [N/m]), or a file: [{"name", "stiffness" [N/m], "damping"
// [N s/m], "hardness" [Pa], "density" [kg/m^3]}, ...]. Throws BadInput naming `option` and the
// file.
TissueTable readTissues(const std::string& option, const std::string& text, double stiffness);

// "PART=TISSUE". Throws BadInput naming `option`.
std::pair<std::string, std::string> readTissueName(const std::string& option,
                                                   const std::string& text);

// The table's entries in the order of `parts`, each looked up in `tissueOfPart`, else by its own
// name. Throws BadInput for an unknown tissue or part.
TissueTable tissuesOfParts(const std::string& body, const TissueTable& table,
                           const std::vector<std::string>& parts,
                           const std::vector<std::pair<std::string, std::string>>& tissueOfPart);

}  // namespace cloudcontact::program
