// Titles and figures for people.
#include "replay/words.h"

#include "io/figure_text.h"

namespace cloudcontact::program {

std::string setupText(const WorldSettings& settings, double step, int substeps) {
  const std::string steps = ", steps of " + timeText(step) +
                            (substeps > 1 ? " in " + std::to_string(substeps) + " parts" : "");
  switch (settings.common.method) {
    case Method::Cloud:
      return "clouds of " + lengthText(settings.voxel) + " voxels" + steps;
    case Method::Gjk:
      return "Bullet's GJK on convex hulls" + steps;
    case Method::Gimpact:
      return "Bullet's GImpact" + steps;
    case Method::Hacd:
      return "convex parts by HACD" + steps;
    case Method::Primitive:
      return "Bullet's own primitives" + steps;
    case Method::Sdf:
      return "Bullet's signed distance fields" + steps;
  }
  return "";
}

std::vector<std::pair<std::string, std::string>> factsOf(const SimulationReport& r) {
  return {{"Deepest overlap, by the meshes", lengthText(r.maxPenetration)},
          {"Contacts a step", numberText(r.contactsPerStep)},
          {"Narrow phase a step", timeText(r.narrowPhaseSeconds / r.steps)},
          {"Energy at the start", energyText(r.energyStart.ofBodies())},
          {"Energy at the end", energyText(r.energyEnd.ofBodies())},
          {"Speed", numberText(r.realTimeFactor) + " \u00d7 real time"}};
}

}  // namespace cloudcontact::program
