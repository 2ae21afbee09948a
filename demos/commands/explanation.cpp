// Puts the reports of pairs into words.
#include "commands/explanation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>

namespace cloudcontact::program {
namespace {

std::string times(std::size_t count, const char* what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : what[0] == 's' ? "es" : "s");
}

void append(std::string& text, const std::string& more) {
  text += (text.empty() ? "" : ", ") + more;
}

std::string kindOf(const std::vector<KnownShape>& known, std::size_t body) {
  for (const KnownShape& shape : known)
    if (shape.body == body) return shape.kind;
  return "primitive";
}

std::string usedBy(const PairUse& pair, const std::vector<KnownShape>& known) {
  const PairReport& r = pair.report;
  std::string used;
  if (r.searched > 0)
    append(used, times(r.searched, "search") + " of " +
                     std::to_string(r.work.samples / r.searched) + " samples");
  if (r.device > 0) append(used, times(r.device, "search") + " on the device");
  if (r.coarser > 0) {
    char text[64];
    std::snprintf(text, sizeof text, "%zu of them with voxels of up to %.2g m", r.coarser,
                  std::max(r.voxel[0], r.voxel[1]));
    append(used, text);
  }
  if (r.refined > 0) append(used, times(r.refined, "search") + " again for their error");
  if (r.moved > 0) append(used, times(r.moved, "contact") + " moved along");
  if (r.shapes > 0)
    append(used, times(r.shapes, "contact") + " of " + kindOf(known, pair.a) + " and " +
                     kindOf(known, pair.b));
  return used;
}

std::string skippedBy(const PairReport& r) {
  std::string skipped;
  if (r.samples > r.work.samples) {
    char text[64];
    const double part = 100.0 * double(r.samples - r.work.samples) / double(r.samples);
    std::snprintf(text, sizeof text, "%.*f %% of the samples", part > 99 ? 1 : 0, part);
    append(skipped, text);
  }
  if (r.moved + r.shapes > 0) append(skipped, times(r.moved + r.shapes, "search"));
  if (r.coarser > 0) append(skipped, "finer voxels");
  if (r.eased > 0) append(skipped, "the tolerance " + times(r.eased, "time") + " for the budget");
  return skipped.empty() ? "nothing" : skipped;
}

}  // namespace

Json explanation(const World& world) {
  std::vector<PairUse> pairs = world.pairs();
  std::stable_sort(pairs.begin(), pairs.end(), [](const PairUse& x, const PairUse& y) {
    return x.report.seconds > y.report.seconds;
  });
  double all = 0;
  for (const PairUse& pair : pairs) all += pair.report.seconds;
  const std::vector<KnownShape> known = world.knownShapes();
  Json rows = Json::array();
  for (const PairUse& pair : pairs) {
    const PairReport& r = pair.report;
    rows.push_back({{"a", world.name(pair.a)},
                    {"b", world.name(pair.b)},
                    {"used", usedBy(pair, known)},
                    {"skipped", skippedBy(r)},
                    {"microseconds", 1e6 * r.seconds / double(r.answers())},
                    {"queries", r.answers()},
                    {"share", all > 0 ? r.seconds / all : 0},
                    {"expectedError", r.expectedError},
                    {"tolerance", r.tolerance},
                    {"voxels", {r.voxel[0], r.voxel[1]}},
                    {"levels", {r.voxelLevel[0], r.voxelLevel[1]}},
                    {"coarser", r.coarser},
                    {"refined", r.refined},
                    {"eased", r.eased}});
  }
  return rows;
}

void printExplanation(const Json& explanation) {
  if (explanation.empty()) {
    std::cout << "  no pair of clouds met\n";
    return;
  }
  std::cout << "  pairs, the costliest first\n";
  for (const Json& row : explanation) {
    char figures[96];
    std::snprintf(figures, sizeof figures, "  %5.1f %%  %8.1f us  within %.2g m  ",
                  100 * row["share"].get<double>(), row["microseconds"].get<double>(),
                  row["expectedError"].get<double>());
    std::cout << figures << row["a"].get<std::string>() << " and " << row["b"].get<std::string>()
              << ": " << row["used"].get<std::string>() << "; left out "
              << row["skipped"].get<std::string>() << '\n';
  }
}

}  // namespace cloudcontact::program
