// What scenes and pairs take: counts that no machine changes (WorkCounts), for
// benchmarks/work.json, and times.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace cloudcontact::program::lab {

// A scene's counts are a step's, a pair's are a query's.
struct WorkEntry {
  std::string name;  // "demo chain", "pair threads (cloud)", "scene cows"
  std::vector<std::pair<std::string, double>> counts;
};

// The narrow phase of a step, or a query [s].
struct WorkTime {
  std::string name;
  double seconds = 0;
  double gimpact = 0;  // of the same bodies as GImpact meshes; 0: not measured
  double gather = 0;   // of reading as many bytes as were looked up, from memory in order
};

// What is counted, and timed on one thread.
struct WorkSource {
  std::string name;  // its entries begin with it
  std::function<std::vector<WorkEntry>()> count;
  std::function<std::vector<WorkTime>(bool gimpact)> time;
};

// The demos' worlds; the scenes of the tests in a checkout of the project, and those of
// ../shared/scenes beside it if they are there; and a pair of each family of the chart. `threads`:
// of the worlds that are counted; the counts are the same.
std::vector<WorkSource> workSources(const std::string& checkout, int threads);

}  // namespace cloudcontact::program::lab
