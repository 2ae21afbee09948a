// The tissues of bodies on the command line: a table by name or from a JSON file, and the tissue of
// each part.
#pragma once

#include <cloudcontact/law/tissue.h>

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "io/options.h"

namespace cloudcontact::program {

// "dental" (with `stiffness` for enamel, [N/m]), or a file: [{"name", "stiffness" [N/m], "damping"
// [N s/m], "hardness" [Pa], "density" [kg/m^3]}, ...]. Throws BadInput naming `option` and the
// file.
TissueTable readTissues(const std::string& option, const std::string& text, double stiffness = 2e4);

// The table of the options, from readTissues() where it is a file's; of the file `usual` where
// there is none.
TissueTable tableOf(const TissueOptions& options, const std::string& usual);

// The table's entries in the order of `parts`, each looked up in `tissueOfPart`, else by its own
// name. Throws BadInput for an unknown tissue or part.
TissueTable tissuesOfParts(const std::string& body, const TissueTable& table,
                           const std::vector<std::string>& parts,
                           const std::vector<std::pair<std::string, std::string>>& tissueOfPart);

// The tissues of bodies that are pressed together, by --tissues and --tissue.
class BodyTissues {
 public:
  // Reads the table. Without --tissues no body has tissues.
  explicit BodyTissues(const TissueOptions& options);

  // Of a body of these parts (Cloud::materials; empty: one part, "all"). Empty for a body of which
  // neither --tissue nor the table names a part: it is rigid beside tissues. Throws BadInput where
  // only some of its parts have a tissue.
  TissueTable of(const std::string& body, const std::vector<std::string>& parts);

  // After all bodies: throws BadInput where --tissue names a part that none has, or none has
  // tissues.
  void check() const;

 private:
  TissueTable table_;
  std::vector<std::pair<std::string, std::string>> ofParts_;
  std::set<std::string> seen_;  // parts
  bool any_ = false;
};

}  // namespace cloudcontact::program
