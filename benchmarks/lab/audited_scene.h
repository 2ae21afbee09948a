// A scene of a file, run with an energy audit, as a table for people and as JSON.
#pragma once

#include <optional>
#include <string>

#include "io/options.h"

namespace cloudcontact::program::lab {

struct AuditedScene {
  std::string file;                    // SDFormat or URDF
  CommonOptions common;                // voxel and unit count
  double seconds = 5;                  // simulated
  std::optional<double> step;          // [s]; that of the scene if not given
  std::optional<int> iterations = {};  // WorldSettings::iterations
  std::string out = "bench-results";   // folder of audit.json
};

// Prints the table and writes audit.json with the parts of each step. Throws BadInput where the
// scene is none or has bodies that are cut or deform, whose energy the audit does not know.
void auditScene(const AuditedScene& scene);

}  // namespace cloudcontact::program::lab
